module bw_half_spectrum
  !! Real samples from the half of their spectrum with frequencies 0 … ½, in place.
  !!
  !! The M real samples are taken as M/2 complex ones, even samples as real and odd ones as imaginary parts: a complex
  !! transform of half the length. FFTW plans such a transform in a tenth of the time that it takes for its own
  !! transform to real samples, which for a single history is longer than the transform itself.
  use, intrinsic :: iso_c_binding
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: next_fast_half

  include 'fftw3.f03'

  type, public :: half_spectrum_plan
    !! FFTW's plan for one length, made when it is first needed.
    private
    integer :: half = 0
    type(c_ptr) :: plan = c_null_ptr
  contains
    procedure :: samples => samples_of_half_spectra
    final :: destroy
  end type half_spectrum_plan

  real(dp), parameter :: pi = acos(-1.0_dp)
  integer, parameter :: block = 256            !! tuned: factors of one block stay in the fastest cache

contains

  elemental integer function next_fast_half(least) result(half)
    !! The smallest number from `least` on that is a power of two times 1, 9/8, 5/4, 3/2, 25/16 or 15/8: FFTW is at
    !! its fastest there.
    integer, intent(in) :: least           !! ≥ 1
    integer, parameter :: odd(6) = [1, 3, 5, 9, 15, 25]
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

  subroutine samples_of_half_spectra(self, half, spectra)
    !! In: G_m, m = 0 … M/2, real and imaginary parts in turn. Out: x_j = Re(G_0) + 2 Re Σ_{0<m<M/2} G_m e^(2πi jm/M)
    !! + (−1)^j Re(G_{M/2}), j = 0 … M − 1, and two numbers without meaning.
    !! Planned with FFTW_ESTIMATE: measured plans differ from run to run, and so would the last bits.
    class(half_spectrum_plan), intent(inout) :: self
    integer, intent(in) :: half                        !! M/2
    real(dp), intent(inout), target :: spectra(:, :)   !! (M + 2, histories), histories not far apart
    complex(c_double_complex), pointer :: before(:), after(:)      ! one place under two names: in place
    integer :: h
    call pack_halves(half, spectra)
    do h = 1, size(spectra, 2)
      call c_f_pointer(c_loc(spectra(1, h)), before, [half])
      call c_f_pointer(c_loc(spectra(1, h)), after, [half])
      if (self%half /= half) then
        call destroy(self)
        self%plan = fftw_plan_dft_1d(int(half, c_int), before, after, FFTW_BACKWARD, FFTW_ESTIMATE)
        self%half = half
      end if
      call fftw_execute_dft(self%plan, before, after)
    end do
  end subroutine samples_of_half_spectra

  subroutine destroy(self)
    type(half_spectrum_plan), intent(inout) :: self
    if (self%half /= 0) call fftw_destroy_plan(self%plan)
    self%half = 0
  end subroutine destroy

  pure subroutine pack_halves(half, spectra)
    !! Z_m = A + B and Z_{M/2−m} = conj(A − B) with A = G_m + conj(G_{M/2−m}) and
    !! B = i e^(2πi m/M) (G_m − conj(G_{M/2−m})).
    integer, intent(in) :: half
    real(dp), intent(inout) :: spectra(0:, :)
    real(dp), dimension(block) :: angle, c, s
    integer :: first, h, i, last
    do h = 1, size(spectra, 2)
      call pack_ends(spectra(0, h), spectra(1, h), spectra(2*half, h))
      if (mod(half, 2) == 0) call pack_middle(spectra(half:half + 1, h))
    end do
    do first = 1, (half - 1)/2, block
      last = min(first + block - 1, (half - 1)/2)
      angle = [(pi*(first + i)/half, i=0, block - 1)]
      c = cos(angle)      ! apart from the sines: a loop of both would call them one angle at a time
      s = sin(angle)
      do h = 1, size(spectra, 2)
        call pack_pairs(last - first + 1, c, s, spectra(2*first:2*last + 1, h), &
                        spectra(2*(half - last):2*(half - first) + 1, h))
      end do
    end do
  end subroutine pack_halves

  pure subroutine pack_pairs(count, c, s, low, high)
    !! Pairs m = first … last and M/2 − m.
    integer, intent(in) :: count
    real(dp), intent(in) :: c(count), s(count)         !! cos and sin of 2π m/M
    real(dp), intent(inout) :: low(2, count)           !! G_m, then Z_m
    real(dp), intent(inout) :: high(2, count)          !! the partners, from the last to the first
    real(dp) :: a_re, a_im, b_re, b_im, d_re, d_im
    integer :: i, j
    do i = 1, count
      j = count + 1 - i
      a_re = low(1, i) + high(1, j)
      a_im = low(2, i) - high(2, j)
      d_re = low(1, i) - high(1, j)
      d_im = low(2, i) + high(2, j)
      b_re = -(c(i)*d_im + s(i)*d_re)
      b_im = c(i)*d_re - s(i)*d_im
      low(1, i) = a_re + b_re
      low(2, i) = a_im + b_im
      high(1, j) = a_re - b_re
      high(2, j) = b_im - a_im
    end do
  end subroutine pack_pairs

  pure subroutine pack_ends(first_re, first_im, last_re)
    !! m = 0, whose partner is the real end of the half spectrum.
    real(dp), intent(inout) :: first_re, first_im
    real(dp), intent(in) :: last_re
    first_im = first_re - last_re
    first_re = first_re + last_re
  end subroutine pack_ends

  pure subroutine pack_middle(middle)
    !! m = M/4, its own partner: 2 conj(G).
    real(dp), intent(inout) :: middle(2)
    middle = [2.0_dp*middle(1), -2.0_dp*middle(2)]
  end subroutine pack_middle

end module bw_half_spectrum
