module bw_window
  !! Windows of an amplitude spectrum: sums of cosines, in the periodic form that a Fourier transform asks for.
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: is_known_window, known_windows, window_samples

  real(dp), parameter :: pi = acos(-1.0_dp)

contains

  pure function known_windows() result(words)
    !! The accepted words, separated by blanks, the default first.
    character(:), allocatable :: words
    words = 'hann rectangular hamming blackman blackman_harris flat_top'
  end function known_windows

  pure logical function is_known_window(word)
    !! Whether `word` (lower case) names a window.
    character(*), intent(in) :: word
    is_known_window = size(window_coefficients(word)) > 0
  end function is_known_window

  pure function window_samples(word, count) result(weight)
    !! w_j = Σ_q (−1)^q a_q cos(2πqj/count), j = 0 … count−1, (count).
    !! A record too short for the window's main lobe, or a word that is not known, gets the rectangular window.
    character(*), intent(in) :: word
    integer, intent(in) :: count
    real(dp) :: weight(count)
    real(dp), allocatable :: a(:)
    integer :: j, q
    allocate (a, source=window_coefficients(word))
    if (count < 2*size(a) .or. size(a) == 0) a = [1.0_dp]
    weight = a(1)
    do q = 1, size(a) - 1
      weight = weight + (-1)**q*a(q + 1)*[(cos(2*pi*q*real(j, dp)/count), j=0, count - 1)]
    end do
  end function window_samples

  pure function window_coefficients(word) result(a)
    !! a_0, a_1, … of the window; none if the word is not known.
    !! Source: Harris, Proc. IEEE 66 (1978) 51; flat_top: ISO 18431-2.
    character(*), intent(in) :: word
    real(dp), allocatable :: a(:)
    select case (word)
    case ('rectangular')
      a = [1.0_dp]
    case ('hann')
      a = [0.5_dp, 0.5_dp]
    case ('hamming')
      a = [0.54_dp, 0.46_dp]
    case ('blackman')
      a = [0.42_dp, 0.5_dp, 0.08_dp]
    case ('blackman_harris')
      a = [0.35875_dp, 0.48829_dp, 0.14128_dp, 0.01168_dp]
    case ('flat_top')
      a = [1.0_dp, 1.933_dp, 1.286_dp, 0.388_dp, 0.0322_dp]
    case default
      allocate (a(0))
    end select
  end function window_coefficients

end module bw_window
