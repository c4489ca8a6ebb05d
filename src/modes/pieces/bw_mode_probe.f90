module bw_mode_probe
  !! A beam of pieces at one frequency: how many modes lie below, where the next mode is, and what it looks like.
  !!
  !! Inverse iteration gives motions u that fail the conditions at the joints by a little, e. With the exact mode φ, at
  !! β² + δ, Green's identity reads δ⟨φ, u⟩ = Σ (φ_v e_N + φ_ψe_M − φ_Ne_v − φ_Me_ψ), ⟨·,·⟩ weighted by all mass and
  !! inertia. Put u for φ: the error of δ is of the second order. The factors of e, scaled as the rows are, are the
  !! left null vector of the conditions and the best right side of the next iteration.
  use bw_double_double, only: dd, operator(-), operator(*)
  use bw_joint_elimination, only: eliminate, elimination, joint_loads, solve
  use bw_kinds, only: dp
  use bw_mode_count, only: modes_below
  use bw_piece_beam, only: piece_beam
  use bw_piece_ends, only: find_ends, piece_ends
  use bw_piece_integrals, only: mean_squares
  use bw_piece_waves, only: frequency_at, numbers_of, piece_frequency, piece_numbers
  implicit none (type, external)
  private
  public :: system_of, probe_for, start_anew, probe_at, count_below, improve, weigh, mask_ends, end_states, joint_motion

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
    real(dp), allocatable :: drive(:, :)           !! right side of the inverse iteration in these units, (4, 0:n)
    real(dp), allocatable :: amplitude(:, :)       !! of the motions of each piece, (4, n)
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
    allocate (probe%ends(n), probe%loads(0:n), probe%unit(4, 0:n), probe%drive(4, 0:n), probe%amplitude(4, n))
    allocate (probe%factors%inside(4, 2, n), probe%factors%upper(8, 4, n), probe%factors%right(4, n))
    allocate (probe%factors%row_size(4, 0:n))
    call start_anew(system, 1, probe)
  end function probe_for

  pure subroutine start_anew(system, number, probe)
    !! A right side that no mode escapes, one of many.
    type(piece_system), intent(in) :: system
    integer, intent(in) :: number
    type(mode_probe), intent(inout) :: probe
    integer :: i
    probe%drive = reshape([(sin(real(1 + 7*number*i*i, dp)), i=1, size(probe%drive))], shape(probe%drive))
    call mask_ends(system%beam, probe%drive)
  end subroutine start_anew

  pure subroutine mask_ends(beam, values)
    !! The root and the tip have two conditions each.
    type(piece_beam), intent(in) :: beam
    real(dp), intent(inout) :: values(:, 0:)
    values(merge(4, 1, beam%root%holds_deflection), 0) = 0.0_dp
    values(merge(3, 2, beam%root%holds_turning), 0) = 0.0_dp
    values(1:2, ubound(values, 2)) = 0.0_dp
  end subroutine mask_ends

  pure subroutine probe_at(system, lambda, probe)
    !! Set up and eliminate the conditions at a frequency.
    type(piece_system), intent(in) :: system
    type(dd), intent(in) :: lambda                 !! > 0, unless all pieces are short
    type(mode_probe), intent(inout) :: probe
    real(dp) :: right(4, 0:size(system%piece))
    integer :: i, q
    probe%frequency = frequency_at(system%beam, lambda)
    do i = 1, size(system%piece)
      call find_ends(system%piece(i), probe%frequency, probe%ends(i))
    end do
    do i = 0, size(system%piece)
      do q = 1, 4
        probe%unit(q, i) = max(abs(probe%ends(max(i, 1))%outer(q, 1)), abs(probe%ends(max(i, 1))%outer(q, 2)), &
                               abs(probe%ends(max(i, 1))%outer(q, 3)), abs(probe%ends(max(i, 1))%outer(q, 4)))
        right(q, i) = probe%unit(q, i)*probe%drive(q, i)
      end do
    end do
    call find_loads(system%beam, probe%frequency, probe%loads)
    call eliminate(system%beam%root, probe%loads, probe%ends, right, probe%factors)
  end subroutine probe_at

  pure subroutine find_loads(beam, frequency, loads)
    type(piece_beam), intent(in) :: beam
    type(piece_frequency), intent(in) :: frequency
    type(joint_loads), intent(out) :: loads(0:)
    integer :: i
    loads(0) = joint_loads(beam%root%stiffness%hi, beam%root%turning_stiffness%hi)
    do i = 1, size(beam%joint)
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

  pure subroutine improve(system, probe, correction)
    !! The motions that inverse iteration gives at the frequency of a probe, and by how much β² and λ of their mode differ
    !! from it.
    type(piece_system), intent(in) :: system
    type(mode_probe), intent(inout) :: probe
    real(dp), intent(out) :: correction
    real(dp) :: left(4, 0:size(probe%ends)), largest
    integer :: i, q
    call solve(probe%factors, probe%amplitude)
    call weigh(system, probe, left)
    correction = 0.0_dp
    largest = 0.0_dp
    do i = 0, size(probe%ends)
      do q = 1, 4
        correction = correction + left(q, i)*probe%unit(q, i)*probe%drive(q, i)
        probe%drive(q, i) = left(q, i)/probe%unit(5 - q, i)
        largest = max(largest, abs(probe%drive(q, i)))
      end do
    end do
    correction = correction/probe%mass
    probe%drive = probe%drive*(1.0_dp/largest)
  end subroutine improve

  pure subroutine weigh(system, probe, left)
    !! The modal mass, and the factors of what the conditions lack.
    type(piece_system), intent(in) :: system
    type(mode_probe), intent(inout) :: probe
    real(dp), intent(out) :: left(4, 0:size(probe%ends))
    real(dp) :: before(4), after(4), next(4), squares(2)
    integer :: i, n
    n = size(probe%ends)
    before = 0.0_dp
    probe%mass = 0.0_dp
    do i = 0, n
      after = 0.0_dp
      if (i < n) call end_states(probe%ends(i + 1), probe%amplitude(:, i + 1), after, next)
      if (i == 0) before = after
      if (i > 0) before(1:2) = joint_motion(probe%loads(i), probe%unit(:, i), before, after)
      left(:, i) = [-after(4), -after(3), before(2), before(1)]
      if (i > 0) then
        probe%mass = probe%mass + system%beam%joint(i)%mass%hi*before(1)**2 + system%beam%joint(i)%inertia%hi*before(2)**2
      end if
      if (i == n) exit
      before = next
      squares = mean_squares(system%piece(i + 1), probe%frequency, probe%ends(i + 1), probe%amplitude(:, i + 1))
      probe%mass = probe%mass + system%piece(i + 1)%mass%hi*squares(1) + system%piece(i + 1)%rotary%hi*squares(2)
    end do
    call mask_ends(system%beam, left)
  end subroutine weigh

  pure function joint_motion(load, unit, before, after) result(motion)
    !! Deflection and turning of a joint: those of the piece before it or, where what is attached hardly lets it move, those
    !! that the jumps of force and moment take.
    type(joint_loads), intent(in) :: load
    real(dp), intent(in) :: unit(4)                !! sizes of v, ψ, M and N
    real(dp), intent(in) :: before(4), after(4)    !! states of the pieces on both sides; after the tip 0
    real(dp) :: motion(2)
    motion = before(1:2)
    if (abs(load%deflection)*unit(1) > unit(4)) motion(1) = (after(4) - before(4))/load%deflection
    if (abs(load%turning)*unit(2) > unit(3)) motion(2) = (after(3) - before(3))/load%turning
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
