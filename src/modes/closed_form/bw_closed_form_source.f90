module bw_closed_form_source
  !! All modes of a uniform clamped beam with a tip mass by their numbers, in closed form: whole sets, and the terms of
  !! sums over millions of modes.
  use bw_constants, only: pi
  use bw_kinds, only: dp
  use bw_closed_form, only: closed_form_set, find_cached_modes, find_modes
  use bw_double_double, only: dd, to_dd, operator(*)
  use bw_far_modes, only: far_beam, far_terms, light_modes
  use bw_frequency_equation, only: highest_mode
  use bw_mode_cache, only: mode_cache
  use bw_mode_set, only: batch, mode_set, mode_source, terms_of_set
  use bw_monitor, only: monitor_type
  use bw_piece_beam, only: uniform_piece
  use bw_root_list, only: near_modes
  implicit none (type, external)
  private
  public :: source_in_closed_form

  type, extends(mode_source), public :: closed_form_source
    type(dd) :: mass_ratio                         !! γ to all digits
    type(dd), allocatable :: omega                 !! in-plane angular velocity in h/l²; unallocated: no effect
    type(mode_cache), pointer :: cache => null()   !! shared by cases; not associated: no cache
    real(dp), allocatable :: points(:)             !! ξ at which shapes will be needed; unallocated: none
  contains
    procedure :: find => find_in_closed_form
    procedure :: terms => terms_in_closed_form
  end type closed_form_source

  interface source_in_closed_form
    module procedure :: source_of_number, source_of_ratio
  end interface source_in_closed_form

contains

  pure type(closed_form_source) function source_of_number(gamma, omega) result(source)
    !! Return `source_of_ratio` for a mass ratio in binary64.
    real(dp), intent(in) :: gamma                  !! mass ratio, ≥ 0
    type(dd), intent(in), optional :: omega
    source = source_of_ratio(to_dd(gamma), omega)
  end function source_of_number

  pure type(closed_form_source) function source_of_ratio(gamma, omega) result(source)
    !! Return a source of all modes of a uniform beam with a tip mass, up to `highest_mode`.
    type(dd), intent(in) :: gamma                  !! mass ratio, ≥ 0
    type(dd), intent(in), optional :: omega        !! in-plane angular velocity in h/l²; absent: no effect
    source%gamma = gamma%hi
    source%mass_ratio = gamma
    source%highest = highest_mode
    source%pieces%captured%mass = gamma
    source%pieces%beam%piece = [uniform_piece()]
    source%pieces%beam%joint = [source%pieces%captured]
    if (.not. present(omega)) return
    source%omega = omega
    source%pieces%beam%spin_squared = omega*omega
    source%pieces%beam%in_plane = .true.
  end function source_of_ratio

  subroutine find_in_closed_form(self, number, modes, longest, monitor)
    !! Find modes by numbers, in the cache if it has room for them.
    class(closed_form_source), intent(in) :: self
    integer, intent(in) :: number(:)
    class(mode_set), allocatable, intent(out) :: modes
    real(dp), intent(in), optional :: longest
    class(monitor_type), intent(inout), optional :: monitor
    type(closed_form_set), allocatable :: found
    integer :: place
    logical :: is_cached
    allocate (found)
    is_cached = associated(self%cache)
    if (is_cached) is_cached = self%cache%has_room_for_set(number)
    if (is_cached) then
      call self%cache%find_set(size(number), self%mass_ratio, place)
      call find_cached_modes(self%cache%sets(place), self%omega, longest, self%points, found)
    else
      call find_modes(number, self%mass_ratio, self%omega, longest, found, monitor)
    end if
    call found%damp(self%damping)
    call move_alloc(found, modes)
  end subroutine find_in_closed_form

  subroutine terms_in_closed_form(self, number, xi, longest, beta, drive, shapes, mass)
    !! Find terms of far modes by asymptotic formulas, of others through a set.
    class(closed_form_source), intent(in) :: self
    integer, intent(in) :: number(:)
    real(dp), intent(in) :: xi(:)
    real(dp), intent(in) :: longest
    type(dd), intent(out) :: beta(:)
    real(dp), intent(out) :: drive(:), shapes(:, :)
    real(dp), intent(out) :: mass(:)
    type(far_beam) :: beam
    integer :: light, near
    beam%gamma = self%mass_ratio
    if (allocated(self%omega)) beam%omega = self%omega
    beam%longest = longest
    near = max(near_modes(number, self%gamma), count(number <= modes_of_series(xi)))
    light = max(near, light_modes(number, self%gamma))
    if (near > 0) call terms_of_set(self, number(:near), xi, longest, beta(:near), drive(:near), shapes(:near, :), mass(:near))
    call add_far(near + 1, light)
    call add_far(light + 1, size(number))
  contains
    subroutine add_far(from, to)
      !! Find terms of far modes, all light or all heavy.
      integer, intent(in) :: from, to              !! indices in the list
      integer :: first, last
      do first = from, to, batch
        last = min(first + batch - 1, to)
        call far_terms(number(first:last), beam, xi, beta(first:last), drive(first:last), shapes(first:last, :), mass(first:last))
      end do
    end subroutine add_far
  end subroutine terms_in_closed_form

  pure integer function modes_of_series(xi) result(k)
    !! Return the highest mode that needs its power series, αξ < ½, at one of the points.
    real(dp), intent(in) :: xi(:)
    real(dp) :: alpha
    alpha = 0.5_dp/minval(xi, mask=xi > 0.0_dp)
    k = int(min(real(highest_mode, dp), alpha/pi + 2.0_dp))
  end function modes_of_series

end module bw_closed_form_source
