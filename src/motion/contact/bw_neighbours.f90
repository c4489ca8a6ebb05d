module bw_neighbours
  !! Errors of a motion through contacts, by an ensemble of perturbed motions, called neighbours. In each, every input
  !! number and every computed state has a random error of several standard errors. Their distance from the motion is
  !! its error; once they behave differently, the motion is unknown.
  !!
  !! Perturbations are random, but the same in every run, with mean 0 over the neighbours, so the motion is amid them.
  !! Contacts amplify one direction most. In that direction the true error is a normal deviate, and the n neighbours
  !! have eight times n − 1 independent ones. By Student's distribution one motion in 10⁴ then exceeds the farthest of
  !! them; with a single neighbour, whose direction may be harmless, it would be one in twelve.
  use bw_contact_modes, only: contact_set
  use bw_contact_motion, only: contact_motion
  use bw_double_double, only: dd, operator(+), operator(-)
  use bw_kinds, only: dp, i8
  use bw_mode_set, only: mode_set
  use bw_oscillators, only: moving_state, oscillators_of
  use bw_segment, only: alone, together
  implicit none (type, external)
  private
  public :: errors_of, lags_of

  integer, parameter, public :: neighbours = 6
  real(dp), parameter :: spread = 8.0_dp          !! standard errors

  type, public :: scatter_type
    !! A source of perturbations.
    integer(i8), private :: seed = 88172645463325252_i8   !! not 0
    real(dp), allocatable, private :: slant(:, :)         !! systematic rounding, (oscillators, neighbours)
    real(dp) :: data_error = 0.0_dp                       !! largest relative perturbation of an input
  contains
    procedure, private :: draw
    procedure :: vary
    procedure, private :: vary_parts
    procedure :: press
    procedure :: blur
    procedure :: push
  end type scatter_type

contains

  pure subroutine draw(self, off)
    !! Draw perturbations in standard errors: uniform, by Marsaglia's generator, with mean 0 over the neighbours.
    class(scatter_type), intent(inout) :: self
    real(dp), intent(out) :: off(:, :)             !! (numbers, neighbours)
    integer :: i, j
    do j = 1, size(off, 2)
      do i = 1, size(off, 1)
        self%seed = ieor(self%seed, ishft(self%seed, 13))
        self%seed = ieor(self%seed, ishft(self%seed, -7))
        self%seed = ieor(self%seed, ishft(self%seed, 17))
        off(i, j) = spread*sqrt(3.0_dp)*(real(self%seed, dp)/2.0_dp**63)
      end do
    end do
    do i = 1, size(off, 1)
      off(i, :) = off(i, :) - sum(off(i, :))/size(off, 2)
    end do
  end subroutine draw

  pure subroutine vary(self, free, run)
    !! Create the neighbours of a motion, perturbed by the errors of modes and mass.
    class(scatter_type), intent(inout) :: self
    class(mode_set), intent(in) :: free            !! modes of the beam alone
    type(contact_motion), intent(inout) :: run(0:) !! the motion, and its neighbours
    real(dp), dimension(free%count) :: square_error, mass_error
    real(dp) :: off(free%count + 1, neighbours)
    integer :: i
    call free%number_errors(square_error, mass_error)
    self%data_error = spread*(epsilon(off) + maxval(mass_error))
    allocate (self%slant(free%count + 1, neighbours))
    do i = 1, neighbours
      run(i) = run(0)
    end do
    call self%vary_parts(alone, [square_error, 0.0_dp], [mass_error, 0.0_dp], run)
    call self%draw(self%slant)
    call self%draw(off)
    do i = 1, neighbours
      run(i)%inertia = run(i)%inertia*(1.0_dp + off(:, i)*(epsilon(off) + [mass_error, 0.0_dp]))
    end do
  end subroutine vary

  pure subroutine press(self, modes, run)
    !! Set the modes of beam and mass together in a motion and its neighbours.
    class(scatter_type), intent(inout) :: self
    class(contact_set), intent(in) :: modes
    type(contact_motion), intent(inout) :: run(0:)
    real(dp), dimension(modes%count) :: square_error, mass_error
    call modes%number_errors(square_error, mass_error)
    run(0)%parts(together) = oscillators_of(modes%beta_squared, modes%rates)
    call self%vary_parts(together, square_error, mass_error, run)
  end subroutine press

  pure subroutine vary_parts(self, kind, square_error, rate_error, run)
    !! Perturb the oscillators of the neighbours.
    class(scatter_type), intent(inout) :: self
    integer, intent(in) :: kind
    real(dp), intent(in) :: square_error(:), rate_error(:)    !! of β²; of c, relative, besides rounding
    type(contact_motion), intent(inout) :: run(0:)
    real(dp), dimension(size(rate_error), neighbours) :: off, slower
    integer :: i
    call self%draw(off)
    call self%draw(slower)
    associate (parts => run(0)%parts(kind))
      do i = 1, neighbours
        run(i)%parts(kind) = oscillators_of(parts%beta_squared + off(:, i)*square_error, &
                                            parts%c*(1.0_dp + slower(:, i)*(epsilon(off) + rate_error)))
      end do
    end associate
  end subroutine vary_parts

  pure subroutine blur(self, extent, run)
    !! Perturb the neighbours' states by rounding: random each time, and systematic.
    class(scatter_type), intent(inout) :: self
    real(dp), intent(in) :: extent(:, :)           !! of displacements and velocities since the last state, (oscillators, 2)
    type(contact_motion), intent(inout) :: run(0:)
    real(dp), dimension(size(extent, 1), neighbours) :: off, off_rate
    integer :: i
    call self%draw(off)
    call self%draw(off_rate)
    do i = 1, neighbours
      associate (state => run(i)%state, growth => 1.0_dp + 0.25_dp*epsilon(off)*self%slant(:, i))
        state%u = growth*state%u + epsilon(off)*extent(:, 1)*off(:, i)
        state%v = growth*state%v + epsilon(off)*extent(:, 2)*off_rate(:, i)
      end associate
    end do
  end subroutine blur

  pure subroutine push(self, change, run)
    !! Perturb the neighbours' velocities by a known uncertainty of the motion.
    class(scatter_type), intent(inout) :: self
    real(dp), intent(in) :: change(:)              !! all together, (oscillators)
    type(contact_motion), intent(inout) :: run(0:)
    real(dp) :: off(1, neighbours)
    integer :: i
    call self%draw(off)
    do i = 1, neighbours
      run(i)%state%v = run(i)%state%v + off(1, i)*change
    end do
  end subroutine push

  pure function errors_of(run, kind, state, time) result(error)
    !! Return the largest differences of displacements and velocities from the motion within a time, compared at the same instant.
    type(contact_motion), intent(in) :: run(0:)    !! the motion, and its neighbours
    integer, intent(in) :: kind                    !! configuration that moves
    type(moving_state), intent(in) :: state(0:)    !! at nearly the same time
    real(dp), intent(in) :: time
    real(dp) :: error(size(state(0)%u), 2)
    type(moving_state) :: motion, neighbour
    real(dp) :: lag(neighbours)
    integer :: i
    error = 0.0_dp
    lag = lags_of(state)
    do i = 1, neighbours
      motion = state(0)
      neighbour = state(i)
      if (lag(i) > 0.0_dp) call run(0)%parts(kind)%move(lag(i), motion)
      if (lag(i) < 0.0_dp) call run(i)%parts(kind)%move(-lag(i), neighbour)
      error = max(error, run(0)%parts(kind)%extent(neighbour%u - motion%u, neighbour%v - motion%v, time))
    end do
  end function errors_of

  pure function lags_of(state) result(lag)
    !! Return the delay of each neighbour at the same event.
    type(moving_state), intent(in) :: state(0:)
    real(dp) :: lag(neighbours)
    type(dd) :: later
    integer :: i
    do i = 1, neighbours
      later = state(i)%time - state(0)%time
      lag(i) = later%hi
    end do
  end function lags_of

end module bw_neighbours
