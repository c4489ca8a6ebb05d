module bw_fourier
  !! Discrete Fourier transform of real records, by FFTW.
  use, intrinsic :: iso_c_binding
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: real_transform

  include 'fftw3.f03'

contains

  function real_transform(samples) result(spectrum)
    !! X_m = Σ_j x_j e^(−2πi mj/N), m = 0 … N/2; (0:N/2).
    !! Planned with FFTW_ESTIMATE: measured plans differ from run to run, and so would the last bits.
    real(dp), intent(in) :: samples(:)            !! the record, (N), N ≥ 1
    complex(dp), allocatable :: spectrum(:)
    real(c_double), allocatable :: copy(:)
    type(c_ptr) :: plan
    allocate (copy(size(samples)), spectrum(0:size(samples)/2))
    plan = fftw_plan_dft_r2c_1d(int(size(samples), c_int), copy, spectrum, FFTW_ESTIMATE)
    copy = samples
    call fftw_execute_dft_r2c(plan, copy, spectrum)
    call fftw_destroy_plan(plan)
  end function real_transform

end module bw_fourier
