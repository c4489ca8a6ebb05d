module bw_piece_source
  !! Modes of a beam of uniform pieces by their numbers, exact for every number.
  use bw_double_double, only: dd, sqrt, operator(+), operator(*)
  use bw_extended_residual, only: refine
  use bw_kinds, only: dp
  use bw_missing, only: missing
  use bw_mode_probe, only: mode_probe
  use bw_mode_search, only: find_mode, mode_search, search_in
  use bw_mode_set, only: least_phase, mode_set, mode_source, near_critical
  use bw_monitor, only: monitor_type, stops
  use bw_piece_beam, only: holds_tip, modes_at_rest, piece_beam, root_power, side_of_tip
  use bw_piece_critical, only: critical_speed_of, without_inertia
  use bw_piece_dispersion, only: mean_waves
  use bw_piece_integrals, only: mean_squares
  use bw_piece_set, only: piece_set
  use bw_piece_waves, only: frequency_at, parts_at_rest, piece_frequency
  use bw_scene_pieces, only: struck_beam
  implicit none (type, external)
  private
  public :: source_of_pieces, set_of_pieces

  integer, parameter :: highest_mode = 10000000, quick_modes = 100000

  type, extends(mode_source), public :: piece_source
    type(dd) :: critical_speed                       !! see mode_set
    logical :: grows_at_any_speed = .false.
  contains
    procedure :: find => find_of_pieces
  end type piece_source

contains

  type(piece_source) function source_of_pieces(pieces) result(source)
    type(struck_beam), intent(in) :: pieces
    source%pieces = pieces
    source%gamma = pieces%captured%mass%hi
    source%highest = highest_mode
    source%quickly = quick_modes
    source%critical_speed = critical_speed_of(pieces%beam)
    source%grows_at_any_speed = modes_at_rest(without_inertia(pieces%beam)) > 0 .and. &
      (pieces%beam%in_plane .or. pieces%beam%spin_squared%hi == 0.0_dp)
    source%struck_at = pieces%position
    source%root_power = root_power(pieces%beam%root)
    source%uniform = size(pieces%beam%piece) == 1 .and. source%root_power == 2 &
      .and. .not. any([pieces%beam%joint%stiffness%hi, pieces%beam%joint%turning_stiffness%hi] > 0.0_dp)
  end function source_of_pieces

  subroutine find_of_pieces(self, number, modes, longest, monitor)
    class(piece_source), intent(in) :: self
    integer, intent(in) :: number(:)
    class(mode_set), allocatable, intent(out) :: modes
    real(dp), intent(in), optional :: longest
    class(monitor_type), intent(inout), optional :: monitor
    type(piece_set), allocatable :: found
    allocate (found)
    if (present(monitor)) then
      call set_of_pieces(self%pieces%beam, number, longest, found, self%pieces%struck, monitor)
    else
      call set_of_pieces(self%pieces%beam, number, longest, found, self%pieces%struck, self%monitor)
    end if
    found%gamma = self%gamma
    found%body_inertia = self%pieces%captured%inertia%hi
    found%critical_speed = self%critical_speed
    found%grows_at_any_speed = self%grows_at_any_speed
    found%struck_at = self%struck_at
    found%uniform = self%uniform
    found%root_power = self%root_power
    if (.not. found%resolved) call self%note_failure(number)
    call found%damp(self%damping)
    call move_alloc(found, modes)
  end subroutine find_of_pieces

  subroutine set_of_pieces(beam, number, longest, set, struck, monitor)
    !! Find modes with given numbers, in that order.
    type(piece_beam), intent(in) :: beam
    integer, intent(in) :: number(:)               !! k ≥ 1, ascending
    real(dp), intent(in), optional :: longest      !! time up to which phases are accurate
    type(piece_set), intent(out) :: set
    integer, intent(in), optional :: struck        !! joint at which a mass strikes; absent: the tip
    class(monitor_type), intent(inout), optional :: monitor   !! the modes are invalid if it requests a stop
    type(mode_search) :: search
    type(dd) :: lambda
    logical :: found
    integer :: j
    search = search_in(beam)
    call size_set(search, size(number), set)
    if (present(struck)) then
      set%struck_joint = struck
      if (size(search%system%piece) > size(beam%piece)) set%struck_joint = sum(parts_of_cut(beam, struck))
    end if
    do j = 1, size(number)
      if (stops(monitor)) return
      call find_mode(search, number(j), lambda, found)
      if (.not. found) then
        set%resolved = .false.
        return
      end if
      if (is_coarse(search, lambda, longest)) call refine(search%system, search%probe, lambda)
      call set_mode(search%probe, number(j), lambda, j, set)
    end do
  end subroutine set_of_pieces

  pure function parts_of_cut(beam, pieces) result(parts)
    !! Return the parts into which a search cuts the first pieces of a beam with modes of λ ≤ 0.
    type(piece_beam), intent(in) :: beam
    integer, intent(in) :: pieces
    integer :: parts(pieces), all(size(beam%piece))
    all = parts_at_rest(beam)
    parts = all(:pieces)
  end function parts_of_cut

  pure subroutine size_set(search, n, set)
    !! Allocate a set with zero motion.
    type(mode_search), intent(in) :: search
    integer, intent(in) :: n
    type(piece_set), intent(inout) :: set
    integer :: pieces
    pieces = size(search%system%piece)
    set%count = n
    set%struck_joint = pieces
    set%modes%system = search%system
    allocate (set%alpha(n), set%phase_velocity(n), set%group_velocity(n), source=missing)
    allocate (set%modal_mass(n), set%modes%mass(n), source=1.0_dp)
    allocate (set%struck(n), set%spun(n), source=0.0_dp)
    allocate (set%beta_squared(n), source=dd(1.0_dp))
    allocate (set%modes%lambda(n), set%modes%square(n))
    allocate (set%modes%amplitude(4, pieces, n), source=0.0_dp)
    allocate (set%modes%deflection(pieces, n), set%modes%turning(pieces, n), set%modes%root(2, n), source=0.0_dp)
  end subroutine size_set

  pure logical function is_coarse(search, lambda, longest)
    !! Return whether a frequency needs more digits than binary64: a phase has an error of half a unit of 1 in it for any
    !! wave number.
    type(mode_search), intent(in) :: search
    type(dd), intent(in) :: lambda
    real(dp), intent(in), optional :: longest
    type(piece_frequency) :: frequency
    real(dp) :: alpha, phase, group
    frequency = frequency_at(search%system%beam, lambda)
    call mean_waves(search%system%piece, frequency, alpha, phase, group)
    is_coarse = .false.
    if (lambda%hi == 0.0_dp) return
    is_coarse = abs(frequency%beta_squared%hi) < near_critical*abs(lambda%hi)
    if (present(longest)) is_coarse = is_coarse .or. .not. (group*epsilon(group)*longest < least_phase)
  end function is_coarse

  pure subroutine set_mode(probe, number, lambda, j, set)
    !! Scale a motion and store it as mode j of a set.
    type(mode_probe), intent(in) :: probe
    integer, intent(in) :: number
    type(dd), intent(in) :: lambda
    integer, intent(in) :: j
    type(piece_set), intent(inout) :: set
    real(dp) :: beam_part, turning_part, side, squares(2), scale
    logical :: held(2)
    integer :: i, n
    associate (system => set%modes%system, modes => set%modes)
      n = size(system%piece)
      beam_part = 0.0_dp
      turning_part = 0.0_dp
      do i = 1, n
        squares = mean_squares(system%piece(i), probe%frequency, probe%ends(i), probe%amplitude(:, i))
        beam_part = beam_part + squares(1)
        turning_part = turning_part + system%piece(i)%rotary%hi*squares(2)
      end do
      modes%deflection(:, j) = probe%motion(1, 1:n)
      modes%turning(:, j) = probe%motion(2, 1:n)
      scale = 1.0_dp/sqrt(beam_part)
      side = side_of_tip(system%beam, probe%motion(:, n), probe%before(2, n))
      if (mod(number, 2) == 0 .neqv. side > 0.0_dp) scale = -scale
      held = holds_tip(system%beam)
      if (held(1)) modes%deflection(n, j) = 0.0_dp
      if (held(2)) modes%turning(n, j) = 0.0_dp
      modes%amplitude(:, :, j) = scale*probe%amplitude
      modes%deflection(:, j) = scale*modes%deflection(:, j)
      modes%turning(:, j) = scale*modes%turning(:, j)
      modes%root(:, j) = scale*probe%motion(:, 0)
      modes%lambda(j) = lambda
      modes%mass(j) = probe%mass*scale**2
      set%modal_mass(j) = modes%mass(j)
      set%struck(j) = modes%deflection(set%struck_joint, j)
      set%spun(j) = turning_part*scale**2
      if (system%beam%in_plane) then
        set%spun(j) = modes%mass(j) - (set%spun(j) + sum(system%beam%joint%inertia%hi*modes%turning(:, j)**2))
      end if
      associate (frequency => frequency_at(system%beam, lambda))
        modes%square(j) = frequency%beta_squared
        set%beta_squared(j) = frequency%beta_squared
        call mean_waves(system%piece, frequency, set%alpha(j), set%phase_velocity(j), set%group_velocity(j))
      end associate
    end associate
  end subroutine set_mode

end module bw_piece_source
