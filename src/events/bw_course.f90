module bw_course
  !! The motion between two events: a set of modes, when it starts, and the state that it starts from. Everything that
  !! follows until the next event is exact: the flow of each mode.
  !!
  !! Without dimensions: times in l²/h, velocities in the approach velocity V, displacements in V l²/h.
  use bw_double_double, only: accurate_sum, dd
  use bw_kinds, only: dp
  use bw_modal_flow, only: flow, slow_exponent
  use bw_mode_set, only: mode_set
  implicit none (type, external)
  private
  public :: append_course, move, beam_energy, leaves_range

  integer, parameter, public :: free_modes = 1, loaded_modes = 2, held_modes = 3
    !! of the beam alone, of the beam with the captured mass, of the beam with a mass that is pressed against it

  type, public :: course_type
    integer :: modes = free_modes            !! which set moves, a number above
    type(dd) :: start                        !! when
    real(dp), allocatable :: q(:)            !! modal displacements then, (modes)
    real(dp), allocatable :: rate(:)         !! modal velocities then, (modes)
  end type course_type

  real(dp), parameter :: largest_exponent = 300.0_dp   !! of growth whose energy is still a number

contains

  pure subroutine append_course(courses, modes, start, q, rate)
    !! One course more; those before it are not copied.
    type(course_type), allocatable, intent(inout) :: courses(:)
    integer, intent(in) :: modes             !! which set moves
    type(dd), intent(in) :: start
    real(dp), intent(in) :: q(:), rate(:)    !! (modes)
    type(course_type), allocatable :: longer(:)
    integer :: i, n
    n = size(courses)
    allocate (longer(n + 1))
    do i = 1, n
      longer(i)%modes = courses(i)%modes
      longer(i)%start = courses(i)%start
      call move_alloc(courses(i)%q, longer(i)%q)
      call move_alloc(courses(i)%rate, longer(i)%rate)
    end do
    longer(n + 1)%modes = modes
    longer(n + 1)%start = start
    allocate (longer(n + 1)%q, source=q)
    allocate (longer(n + 1)%rate, source=rate)
    call move_alloc(longer, courses)
  end subroutine append_course

  pure subroutine move(modes, elapsed, q, rate)
    !! The state a time later.
    class(mode_set), intent(in) :: modes
    type(dd), intent(in) :: elapsed          !! ≥ 0
    real(dp), intent(inout) :: q(:), rate(:) !! (modes)
    if (allocated(modes%damping)) then
      call flow(modes%beta_squared, modes%damping, elapsed, q, rate)
    else
      call flow(modes%beta_squared, 0.0_dp, elapsed, q, rate)
    end if
  end subroutine move

  pure logical function leaves_range(modes, elapsed)
    !! A mode grows so much in that time that its energy would be no number.
    class(mode_set), intent(in) :: modes
    type(dd), intent(in) :: elapsed
    type(dd) :: exponent(modes%count)
    if (allocated(modes%damping)) then
      exponent = slow_exponent(modes%beta_squared, modes%damping)
    else
      exponent = slow_exponent(modes%beta_squared, 0.0_dp)
    end if
    leaves_range = maxval(exponent%hi)*elapsed%hi > largest_exponent
  end function leaves_range

  pure real(dp) function beam_energy(modes, q, rate) result(energy)
    !! ½ΣM(q̇² + β²q²), m_iV²: kinetic energy and strain, less that of the centrifugal force in the plane of rotation.
    class(mode_set), intent(in) :: modes
    real(dp), intent(in) :: q(:), rate(:)
    energy = 0.5_dp*accurate_sum(modes%modal_mass*(rate**2 + modes%beta_squared%hi*q**2))
  end function beam_energy

end module bw_course
