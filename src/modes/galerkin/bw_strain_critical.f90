module bw_strain_critical
  !! The lowest speed of rotation at which a beam of pieces with tension is unstable, and how many basis functions its modes need.
  use bw_constants, only: pi
  use bw_double_double, only: dd, to_dd
  use bw_kinds, only: dp
  use bw_lapack, only: dsygv
  use bw_mode_demand, only: mode_demand
  use bw_strain_system, only: forms_of_spin
  use bw_tension_layers, only: most_layers
  use bw_varying_beam, only: varying_beam
  implicit none (type, external)
  private
  public :: critical_speed_of, initial_basis_sizes

contains

  pure function initial_basis_sizes(given, count, wanted) result(functions)
    !! Estimate the functions for the shortest wave, which pieces share as in a beam without tension, and for boundary
    !! layers of thickness δ = √(B(1 + sT)/T) due to tension, unless these are separate pieces (bw_tension_layers).
    type(varying_beam), intent(in) :: given
    integer, intent(in) :: count
    type(mode_demand), intent(in) :: wanted
    integer :: functions(size(given%beam%piece))
    real(dp), dimension(size(functions)) :: waves, layers, pull
    associate (piece => given%beam%piece)
      waves = piece%length%hi*sqrt(sqrt(piece%mass%hi/piece%stiffness%hi))
      pull = given%beam%spin_squared%hi*pulls(given)
      layers = piece%length%hi*sqrt(pull/piece%stiffness%hi/(1.0_dp + piece%compliance%hi*pull))
      functions = wanted%functions(pi*count*waves/sum(waves), merge(layers, 0.0_dp, layers <= most_layers))
    end associate
  end function initial_basis_sizes

  pure function pulls(given) result(pull)
    !! Return T/Ω² at the inner ends of the pieces.
    type(varying_beam), intent(in) :: given
    real(dp) :: pull(size(given%law))
    integer :: i
    pull = [(given%law(i)%tension(1) + given%law(i)%pull, i=1, size(pull))]
  end function pulls

  type(dd) function critical_speed_of(given) result(omega)
    !! Return the lowest Ω at which a mode is unstable, 0 if none: there Ω²R balances K + Ω²T, elastic stiffness and
    !! that due to tension. Free rigid motions do not count. At speeds far beyond those that a beam would survive,
    !! tension confines rotation to boundary layers that these functions do not resolve; the error is then up to 1e-3.
    type(varying_beam), intent(in) :: given
    real(dp), parameter :: agreement = 1.0e-11_dp
    integer, parameter :: most_times = 4           ! functions over the first guess
    real(dp) :: square, before, rounding
    integer, dimension(size(given%beam%piece)) :: functions, first
    first = initial_basis_sizes(given, 1, mode_demand())
    functions = first
    call find_critical_square(given, functions, square, rounding)
    do
      before = square
      functions = functions + functions/2
      call find_critical_square(given, functions, square, rounding)
      if (abs(square - before) <= max(agreement*square, 2.0_dp*rounding) .or. sum(functions) > most_times*sum(first)) exit
    end do
    omega = to_dd(sqrt(square))
  end function critical_speed_of

  subroutine find_critical_square(given, functions, s, rounding)
    !! Find Ω² of that speed for given numbers of functions. 1/Ω² is the largest ratio of x·(R − T)x to x·Kx, with rounding
    !! errors from a strong tension. With h(s), the smallest ratio of x·(K + sT)x to x·Rx, it is the root of h(s) = s, without
    !! cancellation; as h is concave, Newton's steps s = x·Kx/x·(R − T)x decrease to it until rounding dominates.
    type(varying_beam), intent(in) :: given
    integer, intent(in) :: functions(:)
    real(dp), intent(out) :: s, rounding           !! 0 if there is none
    real(dp), parameter :: of_the_largest = 1.0e-13_dp     ! rounding error of eigenvalues
    real(dp), allocatable, dimension(:, :) :: elastic, tension, push
    real(dp), allocatable :: value(:), x(:)
    real(dp) :: before, gain
    integer :: info
    s = 0.0_dp
    rounding = 0.0_dp
    call forms_of_spin(given, functions, elastic, tension, push)
    call ratios(push - tension, elastic, value, x, info)
    if (info /= 0) return
    if (value(size(value)) <= of_the_largest*maxval(abs(value))) return   ! tension stabilises every mode
    s = 1.0_dp/value(size(value))
    if (.not. given%is_pulled) return
    rounding = s
    do
      call ratios(push, elastic + s*tension, value, x, info)
      gain = dot_product(x, matmul(push, x)) - dot_product(x, matmul(tension, x))
      if (info /= 0 .or. gain <= 0.0_dp) return
      before = s
      s = dot_product(x, matmul(elastic, x))/gain
      if (.not. abs(s - before) < 0.5_dp*rounding) return
      rounding = abs(s - before)
    end do
  end subroutine find_critical_square

  subroutine ratios(a, b, value, x, info)
    !! Find the eigenvalues of a x = λ b x, ascending, and the vector of the last.
    real(dp), intent(in) :: a(:, :), b(:, :)
    real(dp), allocatable, intent(out) :: value(:), x(:)
    integer, intent(out) :: info                   !! 0 if b is positive definite
    real(dp), allocatable :: vectors(:, :), factor(:, :), work(:)
    integer :: n
    n = size(a, 1)
    vectors = a
    factor = b
    allocate (value(n))
    allocate (work(64*n), source=0.0_dp)           ! OpenBLAS's dsymv reads past what is set, into what traps
    call dsygv(1, 'V', 'L', n, vectors, n, factor, n, value, work, size(work), info)
    x = vectors(:, n)
  end subroutine ratios

end module bw_strain_critical
