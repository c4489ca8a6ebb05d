module bw_mode_probe
  !! A beam of pieces at one frequency: the number of modes below, the next mode, and its motion.
  !!
  !! Inverse iteration gives motions u with residuals e of the conditions at the joints. With the exact mode φ, at β² +
  !! δ, Green's identity is δ⟨φ, u⟩ = Σ (φ_v e_N + φ_ψe_M − φ_Ne_v − φ_Me_ψ), with forces on the piece before the joint
  !! and ⟨·,·⟩ weighted by all mass and inertia. With u for φ the error of δ is of second order.
  !!
  !! A mode is excited best in proportion to its own motion: forces proportional to its deflections, and jumps between
  !! piece and body proportional to its forces, on either side of each body, limited to what these forces bend the
  !! piece: in a stiff piece larger jumps would cause forces that hide those of the mode. A jump between a body and the
  !! piece with which it moves also acts as a force, so that even a heavy body stays at rest.
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
  public :: system_of, probe_for, set_random_drive, start_bodies, set_frequency, probe_at, count_below, iterate_inverse
  public :: improve_drive, respond, find_modal_mass, work_of_drive

  type, public :: piece_system
    !! A beam and the wave parameters of its pieces.
    type(piece_beam) :: beam
    type(piece_numbers), allocatable :: piece(:)   !! (n)
  end type piece_system

  type, public :: mode_probe
    type(piece_frequency) :: frequency
    type(piece_ends), allocatable :: ends(:)       !! (n)
    type(joint_loads), allocatable :: loads(:)     !! (0:n)
    type(elimination) :: factors
    real(dp), allocatable :: unit(:, :)            !! scales of v, ψ, M and N at the joints, without attachments, (4, 0:n)
    real(dp), allocatable :: jump(:, :, :)
      !! scales of jumps of v and ψ before and after each joint, by bending of the piece under these forces, (2, 2, 0:n)
    real(dp), allocatable :: push(:, :)            !! N and M that move a joint so far in a cycle, with its body, (2, 0:n)
    real(dp), allocatable :: drive(:, :, :)
      !! drive of the inverse iteration, in these units: jump before, force, jump after; of v and N, of ψ and M, (3, 2, 0:n)
    real(dp), allocatable :: amplitude(:, :)       !! of the motions of each piece, (4, n)
    real(dp), allocatable :: motion(:, :)          !! of each joint: v and ψ, (2, 0:n)
    real(dp), allocatable :: before(:, :)          !! N and M before each joint, (2, 0:n)
    real(dp), allocatable :: after(:, :)           !! N and M after each joint, (2, 0:n)
    real(dp) :: mass = 0.0_dp                      !! modal mass
  end type mode_probe

contains

  pure type(piece_system) function system_of(beam) result(system)
    type(piece_beam), intent(in) :: beam
    system%beam = beam
    system%piece = numbers_of(beam%piece)
  end function system_of

  pure type(mode_probe) function probe_for(system) result(probe)
    !! Return a probe for a beam.
    type(piece_system), intent(in) :: system
    integer :: n
    n = size(system%piece)
    allocate (probe%ends(n), probe%loads(0:n), probe%unit(4, 0:n), probe%drive(3, 2, 0:n), probe%amplitude(4, n))
    allocate (probe%jump(2, 2, 0:n), probe%push(2, 0:n), probe%motion(2, 0:n), probe%before(2, 0:n), probe%after(2, 0:n))
    call size_elimination(n, probe%factors)
    call set_random_drive(1, probe)
  end function probe_for

  pure subroutine set_random_drive(number, probe)
    !! Set a pseudo-random drive, which excites all modes.
    integer, intent(in) :: number
    type(mode_probe), intent(inout) :: probe
    integer :: i
    probe%drive = reshape([(sin(real(1 + 7*number*i*i, dp)), i=1, size(probe%drive))], shape(probe%drive))
    probe%drive(1, :, [0, size(probe%ends)]) = 0.0_dp      ! root and tip have a piece on one side only
  end subroutine set_random_drive

  pure subroutine start_bodies(number, probe)
    !! Set the same with drives of bodies in proportion to their mass, for modes in which hardly anything else moves.
    integer, intent(in) :: number
    type(mode_probe), intent(inout) :: probe       !! with a frequency
    call set_random_drive(number, probe)
    probe%drive(2, :, :) = probe%drive(2, :, :)*(probe%push/probe%unit(4:3:-1, :))
  end subroutine start_bodies

  pure subroutine probe_at(system, lambda, probe, rough)
    !! Set up and eliminate the conditions at a frequency.
    type(piece_system), intent(in) :: system
    type(dd), intent(in) :: lambda                 !! > 0, unless all pieces are short
    type(mode_probe), intent(inout) :: probe
    logical, intent(in), optional :: rough         !! binary64 suffices; else phases are accurate to the last digit
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
    !! Set up pieces and bodies at a frequency.
    type(piece_system), intent(in) :: system
    type(dd), intent(in) :: lambda
    type(mode_probe), intent(inout) :: probe
    logical, intent(in), optional :: rough         !! see `probe_at`
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
    !! Return displacement and rotation of one end of a piece, with the other held, under forces of given size, at most
    !! those in waves.
    type(piece_numbers), intent(in) :: piece
    real(dp), intent(in) :: sizes(4)               !! scales of v, ψ, M and N
    real(dp) :: jump(2)
    associate (h => piece%half%hi, b => piece%stiffness%hi)
      jump = min(sizes(1:2), [sizes(4)*h*(h**2 + piece%flexible%hi)/b, sizes(3)*h/b])
    end associate
  end function jumps_of

  pure function driven(beam, probe) result(lack)
    !! Return the jumps of v, ψ, M and N at each joint for a drive, (4, 0:n).
    type(piece_beam), intent(in) :: beam
    type(mode_probe), intent(in) :: probe
    real(dp) :: lack(4, 0:size(probe%ends))
    real(dp), dimension(2) :: before, after, relative    ! `relative`: between attachments and the piece with which they move
    integer :: i
    do i = 0, size(probe%ends)
      associate (d => probe%drive(:, :, i), jump => probe%jump(:, :, i), unit => probe%unit(:, i), load => probe%loads(i))
        before = d(1, :)*jump(:, 1)
        after = d(3, :)*jump(:, 2)
        lack(1:2, i) = before + after
        relative = merge(before, -after, load%inside)
        lack(3, i) = unit(3)*d(2, 2) + load%turning*relative(2)
        lack(4, i) = unit(4)*d(2, 1) + load%deflection*relative(1)
      end associate
    end do
    call mask_ends(beam, lack)
  end function driven

  pure subroutine mask_ends(beam, values)
    !! Remove the conditions that do not exist at root and tip.
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
    !! Count the modes below the frequency of a probe.
    type(piece_system), intent(in) :: system
    type(mode_probe), intent(in) :: probe
    integer, intent(out) :: number
    real(dp), intent(out) :: regular               !! see `modes_below`
    call modes_below(system%beam%root, probe%loads, probe%ends, probe%factors, number, regular)
  end subroutine count_below

  pure subroutine iterate_inverse(system, probe, correction)
    !! Do one inverse iteration at the frequency of a probe, and return the correction of β² and λ to those of the mode.
    type(piece_system), intent(in) :: system
    type(mode_probe), intent(inout) :: probe
    real(dp), intent(out) :: correction
    call respond(system, probe)
    correction = sum(work_of_drive(probe, probe))/probe%mass
    call improve_drive(probe)
  end subroutine iterate_inverse

  pure subroutine respond(system, probe)
    !! Find the motion that the drive of a probe excites.
    type(piece_system), intent(in) :: system
    type(mode_probe), intent(inout) :: probe
    call solve(probe%factors, probe%ends, probe%amplitude)
    call keep_in_range(probe)
    call find_modal_mass(system, probe)
  end subroutine respond

  pure subroutine keep_in_range(probe)
    !! Scale down a motion, and its drive, if its mass would overflow, as beside an immense mass.
    type(mode_probe), intent(inout) :: probe
    real(dp), parameter :: large = 1.0e60_dp
    real(dp) :: largest
    largest = maxval(abs(probe%amplitude))
    if (.not. largest > large) return
    probe%amplitude = scale(probe%amplitude, -exponent(largest))
    probe%drive = scale(probe%drive, -exponent(largest))
  end subroutine keep_in_range

  pure subroutine improve_drive(probe)
    !! Set the drive in proportion to the motion.
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

  pure function work_of_drive(probe, driven) result(works)
    !! Return the work of each drive of one probe on the motion of another: forces on deflections, jumps on forces.
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
  end function work_of_drive

  pure subroutine find_modal_mass(system, probe)
    !! Find the modal mass of a motion, and its values at the joints.
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
  end subroutine find_modal_mass

  pure function joint_motion(probe, i, before, after) result(motion)
    !! Return deflection and rotation of joint i with its attachments: those of an adjacent piece less the jump between
    !! them or, for stiff attachments, those due to the forces.
    type(mode_probe), intent(in) :: probe
    integer, intent(in) :: i
    real(dp), intent(in) :: before(4), after(4)    !! states of the pieces on both sides; zero beyond root and tip
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
    !! Return the states at both ends of a piece.
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
