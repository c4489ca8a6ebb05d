module bw_curvature_set
  !! Modes seen through their curvature: sets and sources that are others, but for their shapes, which are Φ_k''(ξ). Whatever
  !! sums the motion of modes, or estimates what a sum lacks, then gives curvatures, and with EI bending moments.
  !!
  !! Over √λ, λ being what bending and shear alone would make of β² (α⁴ in closed form), they are as large as the shapes. A mode's
  !! β is nearly √λ, so that a curvature so scaled has the amplitude of a velocity: h v'' and v_t are the two parts of one wave
  !! function, and what modes that are not summed add to one they add to the other.
  use bw_double_double, only: dd
  use bw_kinds, only: dp
  use bw_mode_set, only: full_numbers, mode_set, mode_source
  use bw_monitor, only: monitor_type
  implicit none (type, external)
  private
  public :: bent_set, bent_source

  type, extends(mode_set), public :: curvature_set
    class(mode_set), allocatable :: seen           !! the modes themselves
    real(dp), allocatable :: scale(:)              !! √λ, over which Φ'' is taken; unallocated: Φ'' itself, (n)
  contains
    procedure :: some_shapes => curvatures
    procedure :: some_curvatures => curvatures
    procedure :: overlap_with_mass
    procedure :: overlap_of_beam
    procedure :: overlap_far_below
    procedure :: elastic
    procedure :: body_energy
    procedure :: in_full
  end type curvature_set

  type, extends(mode_source), public :: curvature_source
    class(mode_source), allocatable :: seen
    logical :: scaled = .false.
  contains
    procedure :: find
  end type curvature_source

contains

  subroutine bent_set(modes, scaled, bent)
    !! A set seen through its curvature; none where there is none.
    class(mode_set), intent(in), optional :: modes
    logical, intent(in) :: scaled
    class(mode_set), allocatable, intent(out) :: bent
    type(curvature_set), allocatable :: found
    type(dd), allocatable :: stiffness(:)
    real(dp), parameter :: at_rest = 1.0e-12_dp    ! λ of a motion that bends nothing, but for rounding
    if (.not. present(modes)) return
    allocate (found)
    allocate (found%seen, source=modes)
    if (scaled) then
      stiffness = modes%elastic()
      found%scale = sqrt(merge(stiffness%hi, 1.0_dp, stiffness%hi > at_rest))
    end if
    found%count = modes%count
    found%gamma = modes%gamma
    if (allocated(modes%alpha)) found%alpha = modes%alpha        ! not of a beam with a mass pressed against it
    found%beta_squared = modes%beta_squared
    if (allocated(modes%square_rounding)) found%square_rounding = modes%square_rounding
    if (allocated(modes%damping)) found%damping = modes%damping
    if (allocated(modes%damped_squared)) found%damped_squared = modes%damped_squared
    if (allocated(modes%law)) found%law = modes%law
    found%struck = modes%struck
    found%agree_from = modes%agree_from
    found%struck_at = modes%struck_at
    found%uniform = modes%uniform
    found%root_power = modes%root_power
    found%modal_mass = modes%modal_mass
    found%critical_speed = modes%critical_speed
    found%grows_at_any_speed = modes%grows_at_any_speed
    found%resolved = modes%resolved
    call move_alloc(found, bent)
  end subroutine bent_set

  subroutine bent_source(source, scaled, bent)
    !! A source of such sets; none where there is none.
    class(mode_source), intent(in), optional :: source
    logical, intent(in) :: scaled
    class(mode_source), allocatable, intent(out) :: bent
    type(curvature_source), allocatable :: found
    if (.not. present(source)) return
    allocate (found)
    allocate (found%seen, source=source)
    found%scaled = scaled
    found%failure => source%failure
    found%monitor => source%monitor
    found%gamma = source%gamma
    found%highest = source%highest
    found%quickly = source%quickly
    found%stretch = source%stretch
    found%decay = source%decay
    found%quadratic = source%quadratic
    found%agree_from = source%agree_from
    found%struck_at = source%struck_at
    found%uniform = source%uniform
    found%root_power = source%root_power
    if (allocated(source%damping)) found%damping = source%damping
    call move_alloc(found, bent)
  end subroutine bent_source

  subroutine find(self, number, modes, longest, monitor)
    class(curvature_source), intent(in) :: self
    integer, intent(in) :: number(:)
    class(mode_set), allocatable, intent(out) :: modes
    real(dp), intent(in), optional :: longest
    class(monitor_type), intent(inout), optional :: monitor
    class(mode_set), allocatable :: seen
    call self%seen%find(number, seen, longest, monitor)
    call bent_set(seen, self%scaled, modes)
  end subroutine find

  pure function curvatures(self, first, last, xi) result(values)
    class(curvature_set), intent(in) :: self
    integer, intent(in) :: first, last
    real(dp), intent(in) :: xi(:)
    real(dp) :: values(last - first + 1, size(xi))
    integer :: p
    values = self%seen%some_curvatures(first, last, xi)
    if (.not. allocated(self%scale)) return
    do p = 1, size(xi)
      where (self%scale(first:last) > 0.0_dp) values(:, p) = values(:, p)/self%scale(first:last)    ! what is rigid does not bend
    end do
  end function curvatures

  ! All else is that of the modes themselves.

  function overlap_with_mass(self, from, amplitude, monitor) result(sums)
    class(curvature_set), intent(in) :: self
    class(mode_set), intent(in) :: from
    real(dp), intent(in) :: amplitude(:)
    class(monitor_type), intent(inout), optional :: monitor
    real(dp) :: sums(self%count)
    select type (from)
    class is (curvature_set)
      sums = self%seen%overlap_with_mass(from%seen, amplitude, monitor)
    class default
      sums = self%seen%overlap_with_mass(from, amplitude, monitor)
    end select
  end function overlap_with_mass

  function overlap_of_beam(self, from, amplitude, monitor) result(sums)
    class(curvature_set), intent(in) :: self
    class(mode_set), intent(in) :: from
    real(dp), intent(in) :: amplitude(:)
    class(monitor_type), intent(inout), optional :: monitor
    real(dp) :: sums(self%count)
    select type (from)
    class is (curvature_set)
      sums = self%seen%overlap_of_beam(from%seen, amplitude, monitor)
    class default
      sums = self%seen%overlap_of_beam(from, amplitude, monitor)
    end select
  end function overlap_of_beam

  function overlap_far_below(self, from, amplitude, monitor) result(sums)
    class(curvature_set), intent(in) :: self
    class(mode_set), intent(in) :: from
    real(dp), intent(in) :: amplitude(:)
    class(monitor_type), intent(inout), optional :: monitor
    real(dp) :: sums(self%count)
    select type (from)
    class is (curvature_set)
      sums = self%seen%overlap_far_below(from%seen, amplitude, monitor)
    class default
      sums = self%seen%overlap_far_below(from, amplitude, monitor)
    end select
  end function overlap_far_below

  pure function elastic(self) result(squares)
    class(curvature_set), intent(in) :: self
    type(dd) :: squares(self%count)
    squares = self%seen%elastic()
  end function elastic

  pure function body_energy(self, q, rate) result(energy)
    class(curvature_set), intent(in) :: self
    real(dp), intent(in) :: q(:), rate(:)
    real(dp) :: energy(2)
    energy = self%seen%body_energy(q, rate)
  end function body_energy

  pure subroutine in_full(self, numbers)
    class(curvature_set), intent(in) :: self
    type(full_numbers), intent(out) :: numbers
    call self%seen%in_full(numbers)
  end subroutine in_full

end module bw_curvature_set
