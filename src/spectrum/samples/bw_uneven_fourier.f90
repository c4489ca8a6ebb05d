module bw_uneven_fourier
  !! The Fourier sums Σ x_n e^(−2πi mτ_n/M), m = 0 … M/2, of samples at any times 0 ≤ τ < M: a Gaussian spreads each sample
  !! over a grid of half steps, FFTW transforms the grid, and the Gaussian's transform is divided out.
  !! Source: Greengard & Lee, SIAM Review 46 (2004) 443.
  use bw_constants, only: pi
  use bw_fourier, only: real_fourier
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: uneven_transform

  integer, parameter :: reach = 12             !! grid points on either side; the error is 1e-12

contains

  subroutine uneven_transform(place, value, length, plan, spectrum)
    !! Transform samples at uneven times.
    real(dp), intent(in) :: place(:)           !! τ, (N), in 0 … M
    real(dp), intent(in) :: value(:)           !! (N)
    integer, intent(in) :: length              !! M, even
    type(real_fourier), intent(inout) :: plan
    complex(dp), intent(out) :: spectrum(0:)   !! (0:M/2)
    real(dp) :: width, away, first, ratio, fixed(-reach:reach)
    integer :: n, l, nearest
    width = pi*reach/(real(length, dp)**2*3)
    fixed = [(exp(-(pi*l/length)**2/(4*width)), l=-reach, reach)]
    call plan%prepare(2*length)
    plan%samples = 0
    do n = 1, size(place)
      nearest = nint(2*place(n))
      away = pi*(2*place(n) - nearest)/length  ! e^(−(a − bl)²) = e^(−a²) (e^(2ab))^l e^(−b²l²)
      ratio = exp(pi*away/(2*length*width))
      first = value(n)*exp(-away**2/(4*width))*ratio**(-reach)
      do l = -reach, reach
        associate (cell => plan%samples(modulo(nearest + l, 2*length) + 1))
          cell = cell + first*fixed(l)
        end associate
        first = first*ratio
      end do
    end do
    call plan%transform()
    do n = 0, length/2
      spectrum(n) = plan%spectrum(n)*sqrt(pi/width)*exp(width*real(n, dp)**2)/(2*length)
    end do
  end subroutine uneven_transform

end module bw_uneven_fourier
