module bw_sine_sum
  !! Sine and cosine sums over grid points half a spacing off the integers, \( y_j = \sum_{m=0}^{n-1} x_m \sin(\pi(m +
  !! ½)j/n) \) and the same with the cosine, by fast transforms of n/2 complex numbers.
  !!
  !! With even grid points in ascending and odd ones in descending order, \( v_r = x_{2r} \), \( v_{n-1-r} = ∓x_{2r+1}
  !! \), both parts are one sum: with \( U_j = e^{iπj/2n} \sum_r v_r e^{2πijr/n} \) the sines are \( y_j =
  !! \mathrm{Im}\,U_j \), \( y_{n-j} = \mathrm{Re}\,U_j \), and the cosines vice versa. The sums are computed from the
  !! transform in blocks, so that the caller can use them while they are in the cache.
  !!
  !! **Source**: Makhoul (1980), doi:10.1109/TASSP.1980.1163351.
  use, intrinsic :: iso_c_binding
  use bw_constants, only: pi
  use bw_kinds, only: dp
  use bw_monitor, only: monitor_type, stops
  implicit none (type, external)
  private
  public :: next_fast_half, fine_turns, turns_of_block, pair_sums, middle_sum, quarter_sums

  include 'fftw3.f03'

  integer, parameter, public :: block = 128    !! tuned: a block stays in the fastest cache

  type, public :: sine_sum_plan
    !! FFTW's plan for one length and alignment, made when first needed.
    private
    integer :: half = 0
    integer(c_int) :: alignment = 0
    type(c_ptr) :: plan = c_null_ptr
  contains
    procedure :: transform => transform_columns
    final :: destroy
  end type sine_sum_plan

  type, public :: turn_block
    !! The factors w = e^(iπj/2n) and w⁵ for `count` consecutive j.
    integer :: first = 1, count = 0
    real(dp), dimension(block) :: c, s, c5, s5
  end type turn_block


contains

  elemental integer function next_fast_half(least) result(half)
    !! Return the smallest number from `least` on that is a power of two times 1, 9/8, 5/4, 3/2, 25/16 or 15/8, which
    !! are fastest in FFTW.
    integer, intent(in) :: least           !! ≥ 1
    integer, parameter :: odd(*) = [1, 3, 5, 9, 15, 25]
    integer :: i, candidate
    half = huge(half)
    do i = 1, size(odd)
      candidate = odd(i)
      do while (candidate < least)
        candidate = 2*candidate
      end do
      half = min(half, candidate)
    end do
  end function next_fast_half

  subroutine transform_columns(self, half, cosines, skip, values, monitor)
    !! Transform columns. In, after the first rows: x_m, m = 0 … n − 1. Out: Z_j, j = 0 … n/2 − 1, real and imaginary
    !! parts alternating: the transform of v taken as n/2 complex numbers, from which `pair_sums`, `middle_sum` and
    !! `quarter_sums` compute the sums. Planned with FFTW_ESTIMATE, as measured plans, and thus the last bits, differ
    !! between runs; and not in place, as planning would take several times as long.
    class(sine_sum_plan), intent(inout) :: self
    integer, intent(in) :: half                    !! n/2
    logical, intent(in) :: cosines(:)              !! columns with sums of cosines
    integer, intent(in) :: skip                    !! rows before the first
    real(dp), intent(inout), contiguous, target :: values(0:, :)   !! (n and more, columns)
    class(monitor_type), intent(inout), optional :: monitor        !! the sums are invalid if it requests a stop
    complex(c_double_complex), pointer :: before(:), after(:)
    real(dp), allocatable, target :: work(:)
    integer :: h
    allocate (work(2*half))
    call c_f_pointer(c_loc(work), before, [half])
    do h = 1, size(values, 2)
      if (stops(monitor)) return
      call c_f_pointer(c_loc(values(skip, h)), after, [half])
      call pack_column(half, merge(1.0_dp, -1.0_dp, cosines(h)), values(skip:skip + 2*half - 1, h), work)
      call prepare(self, half, fftw_alignment_of(values(skip:skip, h)), before, after)
      call fftw_execute_dft(self%plan, before, after)
    end do
  end subroutine transform_columns

  subroutine prepare(self, half, alignment, before, after)
    !! Make a plan unless the present one fits. FFTW does not touch the arrays.
    type(sine_sum_plan), intent(inout) :: self
    integer, intent(in) :: half
    integer(c_int), intent(in) :: alignment
    complex(c_double_complex), intent(inout) :: before(half), after(half)
    if (self%half == half .and. self%alignment == alignment) return
    call destroy(self)
    self%plan = fftw_plan_dft_1d(int(half, c_int), before, after, FFTW_BACKWARD, ior(FFTW_ESTIMATE, FFTW_DESTROY_INPUT))
    self%half = half
    self%alignment = alignment
  end subroutine prepare

  subroutine destroy(self)
    !! Destroy FFTW's plan.
    type(sine_sum_plan), intent(inout) :: self
    if (self%half /= 0) call fftw_destroy_plan(self%plan)
    self%half = 0
  end subroutine destroy

  pure subroutine pack_column(half, sign, x, v)
    !! Put even grid points first, and odd ones behind in descending order.
    integer, intent(in) :: half
    real(dp), intent(in) :: sign                   !! of odd grid points
    real(dp), intent(in) :: x(0:2*half - 1)
    real(dp), intent(out) :: v(0:2*half - 1)
    integer :: r
    do r = 0, half - 1
      v(r) = x(2*r)
    end do
    do r = 0, half - 1
      v(half + r) = sign*x(2*half - 1 - 2*r)
    end do
  end subroutine pack_column

  pure type(turn_block) function fine_turns(half) result(turns)
    !! Return the factors of j = 0 … block − 1.
    integer, intent(in) :: half                    !! n/2
    real(dp) :: angle(block)
    integer :: i
    angle = [(pi*i/(4.0_dp*half), i=0, block - 1)]
    turns%c = cos(angle)      ! apart from the sines, so that the compiler vectorises both
    turns%s = sin(angle)
  end function fine_turns

  pure subroutine turns_of_block(half, fine, first, turns)
    !! Compute the factors of j = first, first + 1 …, up to (half − 1)/2, as products.
    integer, intent(in) :: half, first
    type(turn_block), intent(in) :: fine
    type(turn_block), intent(inout) :: turns
    real(dp) :: c, c2, s, s2
    integer :: i
    turns%first = first
    turns%count = min(block, (half - 1)/2 - first + 1)
    c = cos(pi*first/(4.0_dp*half))
    s = sin(pi*first/(4.0_dp*half))
    do i = 1, block
      turns%c(i) = c*fine%c(i) - s*fine%s(i)
      turns%s(i) = s*fine%c(i) + c*fine%s(i)
    end do
    do i = 1, block
      s2 = 2.0_dp*turns%s(i)*turns%c(i)
      c2 = 1.0_dp - 2.0_dp*turns%s(i)*turns%s(i)
      c = 1.0_dp - 2.0_dp*s2*s2
      s = 2.0_dp*s2*c2
      turns%c5(i) = c*turns%c(i) - s*turns%s(i)
      turns%s5(i) = s*turns%c(i) + c*turns%s(i)
    end do
  end subroutine turns_of_block

  pure subroutine pair_sums(turns, count, low, high, cosine, sums)
    !! Return the sums at j, n/2 + j, n/2 − j and n − j, for the j of a block.
    type(turn_block), intent(in) :: turns
    integer, intent(in) :: count                         !! in the block
    real(dp), intent(in) :: low(2, count)                !! Z_j
    real(dp), intent(in) :: high(2, count)               !! Z_(n/2−j), in descending order of j
    logical, intent(in) :: cosine
    real(dp), intent(out) :: sums(block, 4)
    if (cosine) then
      call turn_pairs(turns, count, low, high, sums(:, 1), sums(:, 4), sums(:, 3), sums(:, 2))
    else
      call turn_pairs(turns, count, low, high, sums(:, 4), sums(:, 1), sums(:, 2), sums(:, 3))
    end if
  end subroutine pair_sums

  pure subroutine turn_pairs(turns, count, low, high, near_re, near_im, far_re, far_im)
    !! Return U_j and U_(n/2−j): with A = Z_j, B = conj(Z_(n/2−j)), P = w(A + B)/2 and S = w⁵(A − B)/2i they are P + S
    !! and e^(iπ/4) conj(P − S).
    type(turn_block), intent(in) :: turns
    integer, intent(in) :: count
    real(dp), intent(in) :: low(2, count), high(2, count)
    real(dp), intent(out), dimension(block) :: near_re, near_im, far_re, far_im
    real(dp), parameter :: root = sqrt(0.125_dp)
    real(dp) :: d_re, d_im, e_re, e_im, p_re, p_im, r_re, r_im
    integer :: i, j
    do i = 1, count
      j = count + 1 - i
      e_re = low(1, i) + high(1, j)
      e_im = low(2, i) - high(2, j)
      d_re = low(2, i) + high(2, j)
      d_im = high(1, j) - low(1, i)
      p_re = turns%c(i)*e_re - turns%s(i)*e_im
      p_im = turns%c(i)*e_im + turns%s(i)*e_re
      r_re = turns%c5(i)*d_re - turns%s5(i)*d_im
      r_im = turns%c5(i)*d_im + turns%s5(i)*d_re
      near_re(i) = 0.5_dp*(p_re + r_re)
      near_im(i) = 0.5_dp*(p_im + r_im)
      far_re(i) = root*((p_re - r_re) + (p_im - r_im))
      far_im(i) = root*((p_re - r_re) - (p_im - r_im))
    end do
  end subroutine turn_pairs

  pure real(dp) function middle_sum(z) result(sum)
    !! Return the sum at n/2, of either kind.
    real(dp), intent(in) :: z(0:)                        !! Z
    sum = sqrt(0.5_dp)*(z(0) - z(1))
  end function middle_sum

  pure function quarter_sums(half, z, cosine) result(sums)
    !! Return the sums at n/4 and 3n/4, where j = n/2 − j; n/2 even.
    integer, intent(in) :: half
    real(dp), intent(in) :: z(0:)                        !! Z
    logical, intent(in) :: cosine
    real(dp) :: sums(2)
    type(turn_block) :: turns
    real(dp) :: all(block, 4)
    turns%c(1) = cos(0.125_dp*pi)
    turns%s(1) = sin(0.125_dp*pi)
    turns%c5(1) = -turns%s(1)
    turns%s5(1) = turns%c(1)
    call pair_sums(turns, 1, z(half:half + 1), z(half:half + 1), cosine, all)
    sums = all(1, :2)
  end function quarter_sums

end module bw_sine_sum
