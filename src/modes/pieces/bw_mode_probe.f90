module bw_mode_probe
  !! A beam of pieces at one frequency: how many modes lie below, where the next mode is, and what it looks like.
  !!
  !! Inverse iteration gives motions u that fail the conditions at the joints by a little, e. With the exact mode φ, at
  !! β² + δ, Green's identity reads δ⟨φ, u⟩ = Σ (φ_v e_N + φ_ψe_M − φ_Ne_v − φ_Me_ψ), forces those of the piece before the
  !! joint, ⟨·,·⟩ weighted by all mass and inertia. Put u for φ: the error of δ is of the second order.
  !!
  !! What excites a mode best is what it weighs: forces in the proportion of its deflections, and jumps between piece and
  !! body in the proportion of its forces, on either side of each body, no larger than these forces bend the piece: larger ones
  !! would ask a stiff piece for forces beside which those of the mode are rounding. Where a jump is between a body and the piece
  !! that it moves with, its load is a force as well: the body stays at rest, however heavy it is.
  use bw_double_double, only: dd, operator(-), operator(*)
  use bw_joint_elimination, only: eliminate, elimination, joint_loads, size_elimination, solve
  use bw_kinds, only: dp
  use bw_mode_count, only: modes_below
  use bw_piece_beam, only: piece_beam
  use bw_piece_ends, only: find_ends, piece_ends
  use bw_piece_integrals, only: mean_squares
  use bw_piece_waves, only: frequency_at, numbers_of, piece_frequency, piece_numbers
  implicit none (type, external)
  private
  public :: system_of, probe_for, start_anew, start_bodies, set_frequency, probe_at, count_below, improve
  public :: improve_drive, keep_in_range, respond, weigh, works_on

  type, public :: piece_system
    !! A beam with what its pieces' waves depend on.
    type(piece_beam) :: beam
    type(piece_numbers), allocatable :: piece(:)   !! (n)
  end type piece_system

  type, public :: mode_probe
    type(piece_frequency) :: frequency
    type(piece_ends), allocatable :: ends(:)       !! (n)
    type(joint_loads), allocatable :: loads(:)     !! (0:n)
    type(elimination) :: factors
    real(dp), allocatable :: unit(:, :)            !! sizes of v, ψ, M and N at the joints, whatever is attached, (4, 0:n)
    real(dp), allocatable :: jump(:, :, :)
      !! jumps of v and ψ before and after each joint, by which these forces bend the piece there, (2, 2, 0:n)
    real(dp), allocatable :: push(:, :)            !! N and M that move a joint so far in a cycle, more where a body is, (2, 0:n)
    real(dp), allocatable :: drive(:, :, :)
      !! what drives the inverse iteration, in these units: jump before, force, jump after; of v and N, of ψ and M, (3, 2, 0:n)
    real(dp), allocatable :: amplitude(:, :)       !! of the motions of each piece, (4, n)
    real(dp), allocatable :: motion(:, :)          !! of each joint: v and ψ, (2, 0:n)
    real(dp), allocatable :: before(:, :)          !! N and M before each joint, (2, 0:n)
    real(dp), allocatable :: after(:, :)           !! N and M after each joint, (2, 0:n)
    real(dp) :: mass = 0.0_dp                      !! modal mass of these
  end type mode_probe

contains

  pure type(piece_system) function system_of(beam) result(system)
    type(piece_beam), intent(in) :: beam
    system%beam = beam
    system%piece = numbers_of(beam%piece)
  end function system_of

  pure type(mode_probe) function probe_for(system) result(probe)
    !! Room for a beam.
    type(piece_system), intent(in) :: system
    integer :: n
    n = size(system%piece)
    allocate (probe%ends(n), probe%loads(0:n), probe%unit(4, 0:n), probe%drive(3, 2, 0:n), probe%amplitude(4, n))
    allocate (probe%jump(2, 2, 0:n), probe%push(2, 0:n), probe%motion(2, 0:n), probe%before(2, 0:n), probe%after(2, 0:n))
    call size_elimination(n, probe%factors)
    call start_anew(1, probe)
  end function probe_for

  pure subroutine start_anew(number, probe)
    !! A drive that no mode escapes, one of many.
    integer, intent(in) :: number
    type(mode_probe), intent(inout) :: probe
    integer :: i
    probe%drive = reshape([(sin(real(1 + 7*number*i*i, dp)), i=1, size(probe%drive))], shape(probe%drive))
    probe%drive(1, :, [0, size(probe%ends)]) = 0.0_dp      ! root and tip have a piece on one side
  end subroutine start_anew

  pure subroutine start_bodies(number, probe)
    !! The same, but that heavy bodies are driven as much as they weigh: for modes in which hardly anything else moves.
    integer, intent(in) :: number
    type(mode_probe), intent(inout) :: probe       !! where a frequency is set
    call start_anew(number, probe)
    probe%drive(2, :, :) = probe%drive(2, :, :)*(probe%push/probe%unit(4:3:-1, :))
  end subroutine start_bodies

  pure subroutine probe_at(system, lambda, probe, rough)
    !! Set up and eliminate the conditions at a frequency.
    type(piece_system), intent(in) :: system
    type(dd), intent(in) :: lambda                 !! > 0, unless all pieces are short
    type(mode_probe), intent(inout) :: probe
    logical, intent(in), optional :: rough         !! binary64 will do; else phases are right to the last digit
    call set_frequency(system, lambda, probe, rough)
    call eliminate_drive(system, probe)
  end subroutine probe_at

  pure subroutine eliminate_drive(system, probe)
    !! Eliminate the conditions at the frequency of a probe, with its drive.
    type(piece_system), intent(in) :: system
    type(mode_probe), intent(inout) :: probe
    call eliminate(system%beam%root, probe%loads, probe%ends, driven(system%beam, probe), probe%factors)
  end subroutine eliminate_drive

  pure subroutine set_frequency(system, lambda, probe, rough)
    !! What pieces and bodies do at a frequency.
    type(piece_system), intent(in) :: system
    type(dd), intent(in) :: lambda
    type(mode_probe), intent(inout) :: probe
    logical, intent(in), optional :: rough         !! as that of `probe_at`
    real(dp) :: sizes(4, size(system%piece))
    integer :: i, before, after
    probe%frequency = frequency_at(system%beam, lambda, rough)
    do i = 1, size(system%piece)
      call find_ends(system%piece(i), probe%frequency, probe%ends(i))
      associate (outer => probe%ends(i)%outer)
        sizes(:, i) = max(abs(outer(:, 1)), abs(outer(:, 2)), abs(outer(:, 3)), abs(outer(:, 4)))
      end associate
    end do
    do i = 0, size(system%piece)
      before = max(i, 1)
      after = min(i + 1, size(system%piece))
      probe%unit(:, i) = max(sizes(:, before), sizes(:, after))
      probe%jump(:, 1, i) = jumps_of(system%piece(before), sizes(:, before))
      probe%jump(:, 2, i) = jumps_of(system%piece(after), sizes(:, after))
      probe%push(:, i) = probe%unit([4, 3], i)
      if (i == 0) cycle
      associate (joint => system%beam%joint(i), square => max(abs(probe%frequency%lambda%hi), abs(probe%frequency%rho%hi)))
        probe%push(:, i) = probe%push(:, i) + square*[joint%mass%hi, joint%inertia%hi]*probe%unit(1:2, i)
      end associate
    end do
    call find_loads(system%beam, probe%frequency, probe%loads)
  end subroutine set_frequency

  pure function jumps_of(piece, sizes) result(jump)
    !! How far forces of their sizes move and turn one end of a piece whose other end is held, at most as far as it moves in waves.
    type(piece_numbers), intent(in) :: piece
    real(dp), intent(in) :: sizes(4)               !! of v, ψ, M and N
    real(dp) :: jump(2)
    associate (h => piece%half%hi, b => piece%stiffness%hi)
      jump = min(sizes(1:2), [sizes(4)*h*(h**2 + piece%flexible%hi)/b, sizes(3)*h/b])
    end associate
  end function jumps_of

  pure function driven(beam, probe) result(lack)
    !! By how much v, ψ, M and N fail at each joint for a drive, (4, 0:n).
    type(piece_beam), intent(in) :: beam
    type(mode_probe), intent(in) :: probe
    real(dp) :: lack(4, 0:size(probe%ends))
    real(dp), dimension(2) :: before, after, apart    ! the last between what is attached and the piece that it moves with
    integer :: i
    do i = 0, size(probe%ends)
      associate (d => probe%drive(:, :, i), jump => probe%jump(:, :, i), unit => probe%unit(:, i), load => probe%loads(i))
        before = d(1, :)*jump(:, 1)
        after = d(3, :)*jump(:, 2)
        lack(1:2, i) = before + after
        apart = merge(before, -after, load%inside)
        lack(3, i) = unit(3)*d(2, 2) + load%turning*apart(2)
        lack(4, i) = unit(4)*d(2, 1) + load%deflection*apart(1)
      end associate
    end do
    call mask_ends(beam, lack)
  end function driven

  pure subroutine mask_ends(beam, values)
    !! The root and the tip have two conditions each.
    type(piece_beam), intent(in) :: beam
    real(dp), intent(inout) :: values(:, 0:)
    values(merge(4, 1, beam%root%holds_deflection), 0) = 0.0_dp
    values(merge(3, 2, beam%root%holds_turning), 0) = 0.0_dp
    values(1:2, ubound(values, 2)) = 0.0_dp
  end subroutine mask_ends

  pure subroutine find_loads(beam, frequency, loads)
    type(piece_beam), intent(in) :: beam
    type(piece_frequency), intent(in) :: frequency
    type(joint_loads), intent(out) :: loads(0:)
    integer :: i
    loads(0) = joint_loads(beam%root%stiffness%hi, beam%root%turning_stiffness%hi)
    do i = 1, size(beam%joint)
      if (i < size(beam%joint)) loads(i)%inside = beam%piece(i)%length%hi < beam%piece(i + 1)%length%hi
      associate (joint => beam%joint(i))
        loads(i)%deflection = load_of(joint%stiffness, joint%mass, frequency%lambda)
        loads(i)%turning = load_of(joint%turning_stiffness, joint%inertia, frequency%beta_squared)
      end associate
    end do
  end subroutine find_loads

  elemental real(dp) function load_of(stiffness, inertia, square) result(load)
    type(dd), intent(in) :: stiffness, inertia, square
    type(dd) :: difference
    load = -inertia%hi*square%hi
    if (stiffness%hi == 0.0_dp) return
    difference = stiffness - inertia*square
    load = difference%hi
  end function load_of

  pure subroutine count_below(system, probe, number, regular)
    !! Modes below the frequency of a probe.
    type(piece_system), intent(in) :: system
    type(mode_probe), intent(in) :: probe
    integer, intent(out) :: number
    real(dp), intent(out) :: regular               !! as that of `modes_below`
    call modes_below(system%beam%root, probe%loads, probe%ends, probe%factors, number, regular)
  end subroutine count_below

  pure subroutine improve(system, probe, correction, mixture)
    !! The motions that inverse iteration gives at the frequency of a probe, and by how much β² and λ of their mode differ
    !! from it.
    type(piece_system), intent(in) :: system
    type(mode_probe), intent(inout) :: probe
    real(dp), intent(out) :: correction
    real(dp), intent(out) :: mixture               !! the same as if all joints called for it alike: that of two modes may cancel
    real(dp) :: works(3, 2, 0:size(probe%ends))
    call respond(system, probe)
    works = works_on(probe, probe)
    correction = sum(works)/probe%mass
    mixture = sum(abs(works))/probe%mass
    call improve_drive(probe)
  end subroutine improve

  pure subroutine respond(system, probe)
    !! The motions that the drive of a probe excites.
    type(piece_system), intent(in) :: system
    type(mode_probe), intent(inout) :: probe
    call solve(probe%factors, probe%ends, probe%amplitude)
    call keep_in_range(probe)
    call weigh(system, probe)
  end subroutine respond

  pure subroutine keep_in_range(probe)
    !! Make a motion smaller, and its drive, whose mass would overflow: one beside an immense mass.
    type(mode_probe), intent(inout) :: probe
    real(dp), parameter :: large = 1.0e60_dp
    real(dp) :: largest
    largest = maxval(abs(probe%amplitude))
    if (.not. largest > large) return
    probe%amplitude = scale(probe%amplitude, -exponent(largest))
    probe%drive = scale(probe%drive, -exponent(largest))
  end subroutine keep_in_range

  pure subroutine improve_drive(probe)
    !! In proportion to what the motion weighs.
    type(mode_probe), intent(inout) :: probe
    real(dp) :: largest, share(4)
    integer :: i, j, n
    n = size(probe%ends)
    largest = 0.0_dp
    do i = 0, n
      share = 1.0_dp/probe%unit(:, i)
      do j = 1, 2
        probe%drive(1, j, i) = -probe%before(j, i)*share(5 - j)
        probe%drive(2, j, i) = probe%motion(j, i)*share(j)*(probe%push(j, i)*share(5 - j))
        probe%drive(3, j, i) = merge(-probe%after(j, i), probe%before(j, i), i < n)*share(5 - j)
        largest = max(largest, abs(probe%drive(1, j, i)), abs(probe%drive(2, j, i)), abs(probe%drive(3, j, i)))
      end do
    end do
    probe%drive = probe%drive*(1.0_dp/largest)
    probe%drive(1, :, [0, n]) = 0.0_dp
  end subroutine improve_drive

  pure function works_on(probe, driven) result(works)
    !! What each drive of a probe does work on in the motion of another: forces on deflections, jumps on forces.
    type(mode_probe), intent(in) :: probe, driven
    real(dp) :: works(3, 2, 0:size(probe%ends))
    integer :: j, n
    n = size(probe%ends)
    do j = 1, 2
      works(1, j, :) = -probe%before(j, :)*driven%jump(j, 1, :)
      works(2, j, :) = probe%motion(j, :)*driven%unit(5 - j, :)
      works(3, j, :) = -probe%after(j, :)*driven%jump(j, 2, :)
      works(3, j, n) = probe%before(j, n)*driven%jump(j, 2, n)
    end do
    works(1, :, [0, n]) = 0.0_dp
    works = works*driven%drive
  end function works_on

  pure subroutine weigh(system, probe)
    !! The modal mass of a motion, and what it does at the joints.
    type(piece_system), intent(in) :: system
    type(mode_probe), intent(inout) :: probe
    real(dp) :: before(4), after(4), next(4), squares(2)
    integer :: i, n
    n = size(probe%ends)
    before = 0.0_dp
    probe%mass = 0.0_dp
    do i = 0, n
      after = 0.0_dp
      if (i < n) call end_states(probe%ends(i + 1), probe%amplitude(:, i + 1), after, next)
      probe%before(:, i) = before([4, 3])
      probe%after(:, i) = after([4, 3])
      probe%motion(:, i) = joint_motion(probe, i, before, after)
      if (i == 0) probe%motion(:, 0) = merge(0.0_dp, probe%motion(:, 0), &
                                             [system%beam%root%holds_deflection, system%beam%root%holds_turning])
      if (i > 0) then
        probe%mass = probe%mass + system%beam%joint(i)%mass%hi*probe%motion(1, i)**2 &
          + system%beam%joint(i)%inertia%hi*probe%motion(2, i)**2
      end if
      if (i == n) exit
      before = next
      squares = mean_squares(system%piece(i + 1), probe%frequency, probe%ends(i + 1), probe%amplitude(:, i + 1))
      probe%mass = probe%mass + system%piece(i + 1)%mass%hi*squares(1) + system%piece(i + 1)%rotary%hi*squares(2)
    end do
  end subroutine weigh

  pure function joint_motion(probe, i, before, after) result(motion)
    !! Deflection and turning of joint i with what is attached to it: those of a piece next to it less the jump that drives
    !! them apart or, where what is attached hardly lets it move, those that the forces take.
    type(mode_probe), intent(in) :: probe
    integer, intent(in) :: i
    real(dp), intent(in) :: before(4), after(4)    !! states of the pieces on both sides; no forces beyond root and tip
    real(dp) :: motion(2)
    associate (d => probe%drive(:, :, i), jump => probe%jump(:, :, i), unit => probe%unit(:, i), load => probe%loads(i))
      if (i == size(probe%ends)) then
        motion = before(1:2) + d(3, :)*jump(:, 2)
      else if (load%inside) then
        motion = before(1:2) - d(1, :)*jump(:, 1)
      else
        motion = after(1:2) + d(3, :)*jump(:, 2)
      end if
      if (abs(load%deflection)*unit(1) > unit(4)) motion(1) = (after(4) - before(4) + unit(4)*d(2, 1))/load%deflection
      if (abs(load%turning)*unit(2) > unit(3)) motion(2) = (after(3) - before(3) + unit(3)*d(2, 2))/load%turning
    end associate
  end function joint_motion

  pure subroutine end_states(ends, amplitude, inner, outer)
    !! The states at both ends of a piece.
    type(piece_ends), intent(in) :: ends
    real(dp), intent(in) :: amplitude(4)
    real(dp), intent(out) :: inner(4), outer(4)
    real(dp) :: even(4), odd(4)
    even = ends%outer(:, 1)*amplitude(1) + ends%outer(:, 2)*amplitude(2)
    odd = ends%outer(:, 3)*amplitude(3) + ends%outer(:, 4)*amplitude(4)
    outer = even + odd
    inner = [even(1) - odd(1), odd(2) - even(2), even(3) - odd(3), odd(4) - even(4)]
  end subroutine end_states

end module bw_mode_probe
