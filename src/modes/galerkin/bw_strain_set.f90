module bw_strain_set
  !! What sets and sources of modes that are known by the coefficients of their strains have in common, be the beam uniform or of
  !! several pieces: modes are taken from those that were solved for, and Rayleigh's damping couples them.
  use bw_damping, only: damping_law
  use bw_double_double, only: dd, to_dd
  use bw_kinds, only: dp
  use bw_mode_set, only: mode_set
  implicit none (type, external)
  private
  public :: choose_squares, products

  type, abstract, extends(mode_set), public :: strain_set
    !! Shapes have ∫Φ² dξ = 1 and a tip value of sign (−1)^k.
    real(dp), allocatable :: rotation(:)           !! β² less the elastic stiffness over the mass, (n)
  contains
    procedure :: take_numbers
    procedure(chosen_interface), deferred :: choose
    procedure(works_interface), deferred :: works
    procedure :: coupling
  end type strain_set

  abstract interface
    subroutine chosen_interface(self, number, chosen)
      !! Take some of these modes, undamped.
      import :: strain_set
      implicit none (type, external)
      class(strain_set), intent(in) :: self
      integer, intent(in) :: number(:)             !! of the modes, ascending
      class(strain_set), allocatable, intent(out) :: chosen
    end subroutine chosen_interface

    pure function works_interface(self) result(works)
      !! The work of the elastic forces of each mode in each, of modes of mass 1, (n, n).
      import :: strain_set, dp
      implicit none (type, external)
      class(strain_set), intent(in) :: self
      real(dp) :: works(self%count, self%count)
    end function works_interface
  end interface

contains

  pure subroutine choose_squares(self, quotient, shift)
    !! Choose β² between that of the singular values, which the set has, and Rayleigh's quotient of the modes' shapes. The former is
    !! a small difference where the shift is larger; and where a system is badly conditioned, as with springs of very different
    !! strength, it is off by all that the two differ, since the quotient is off by the square of what a shape is. Where the two do
    !! not agree at all the modes are not resolved.
    class(strain_set), intent(inout) :: self
    real(dp), intent(in) :: quotient(:)            !! (n)
    real(dp), intent(in) :: shift                  !! σ ≥ 0
    real(dp), parameter :: agreement = 1.0e-8_dp
    real(dp), parameter :: conditioned = 2.0e-14_dp       ! what the two differ by at most where all is well, by experience
    real(dp), parameter :: rounding = 16.0_dp*epsilon(1.0_dp)   ! of β² + σ otherwise, by comparison with power series
    real(dp), dimension(size(quotient)) :: scale, difference
    scale = abs(self%beta_squared%hi) + shift
    difference = abs(quotient - self%beta_squared%hi)
    self%resolved = all(difference <= agreement*scale)
    self%square_rounding = max(rounding*scale, min(difference, conditioned*scale))
    where (abs(self%beta_squared%hi) < 0.5_dp*shift .or. difference > conditioned*scale) self%beta_squared = to_dd(quotient)
  end subroutine choose_squares

  pure subroutine take_numbers(self, all, number)
    !! Take the numbers of some modes, but not their shapes, from those of all that were solved for.
    class(strain_set), intent(inout) :: self
    class(strain_set), intent(in) :: all
    integer, intent(in) :: number(:)               !! of the modes, ascending
    self%count = size(number)
    self%gamma = all%gamma
    self%struck_at = all%struck_at
    self%uniform = all%uniform
    self%root_power = all%root_power
    self%resolved = all%resolved
    self%critical_speed = all%critical_speed
    self%grows_at_any_speed = all%grows_at_any_speed
    self%alpha = all%alpha(number)
    self%beta_squared = all%beta_squared(number)
    if (allocated(all%square_rounding)) self%square_rounding = all%square_rounding(number)
    self%struck = all%struck(number)
    self%modal_mass = all%modal_mass(number)
    self%phase_velocity = all%phase_velocity(number)
    self%group_velocity = all%group_velocity(number)
    self%rotation = all%rotation(number)
  end subroutine take_numbers

  real(dp) function coupling(self, law) result(ratio)
    !! The largest ratio of what damping couples two modes to what damps each, |C_ij|/√(C_iiC_jj): how far the matrix that is
    !! treated as diagonal is from being so.
    class(strain_set), intent(in) :: self
    type(damping_law), intent(in) :: law           !! Rayleigh's: a ratio of each mode couples none
    real(dp) :: gram(self%count, self%count), rate(self%count)
    type(dd) :: elastic(self%count)
    integer :: i, j
    gram = self%works()
    elastic = self%elastic()
    rate = law%rates(elastic%hi)
    ratio = 0.0_dp
    do j = 1, self%count
      do i = 1, j - 1
        if (rate(i) > 0.0_dp .and. rate(j) > 0.0_dp) ratio = max(ratio, abs(gram(i, j))/sqrt(rate(i)*rate(j)))
      end do
    end do
    ratio = ratio*real(law%stiffness, dp)
  end function coupling

  pure function products(onto, from, amplitude) result(sums)
    !! Σ_i a_i Σ_j o_jk f_ji over the coefficients that both sets have, (modes of `onto`).
    real(dp), intent(in) :: onto(:, :), from(:, :)         !! coefficients, (functions, modes)
    real(dp), intent(in) :: amplitude(:)
    real(dp) :: sums(size(onto, 2))
    integer :: n
    n = min(size(onto, 1), size(from, 1))
    sums = matmul(matmul(from(:n, :size(amplitude)), amplitude), onto(:n, :))
  end function products

end module bw_strain_set
