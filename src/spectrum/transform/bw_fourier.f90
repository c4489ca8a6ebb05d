module bw_fourier
  !! This module computes discrete Fourier transforms of real records with FFTW. FFTW's plans, and so the last bits, depend on
  !! addresses modulo 16 bytes: for allocated arrays, and for columns of complex numbers in them, these are 0 in every run.
  use, intrinsic :: iso_c_binding
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: transform_in_place

  include 'fftw3.f03'

  type, public :: real_fourier
    !! The transform X_m = Σ_j x_j e^(−2πi mj/N), m = 0 … N/2, of many records of one length. FFTW's plan is kept, since making it
    !! takes longer than a short transform.
    real(c_double), allocatable :: samples(:)                      !! x, (N); overwritten by `transform`
    complex(c_double_complex), allocatable :: spectrum(:)          !! X, (0:N/2)
    type(c_ptr), private :: plan = c_null_ptr
  contains
    procedure :: prepare
    procedure :: transform
    final :: destroy
  end type real_fourier

contains

  subroutine prepare(self, length)
    !! Allocate arrays and make a plan for records of this length, unless they exist. FFTW_ESTIMATE is used because measured
    !! plans differ from run to run, and with them the last bits.
    class(real_fourier), intent(inout) :: self
    integer, intent(in) :: length                 !! N ≥ 1
    if (allocated(self%samples)) then
      if (size(self%samples) == length) return
      deallocate (self%samples, self%spectrum)
    end if
    call destroy(self)
    allocate (self%samples(length), self%spectrum(0:length/2))
    self%plan = fftw_plan_dft_r2c_1d(int(length, c_int), self%samples, self%spectrum, FFTW_ESTIMATE)
  end subroutine prepare

  subroutine transform(self)
    !! Transform `samples` into `spectrum`.
    class(real_fourier), intent(inout) :: self    !! prepared
    call fftw_execute_dft_r2c(self%plan, self%samples, self%spectrum)
  end subroutine transform

  subroutine destroy(self)
    !! Release FFTW's plan.
    type(real_fourier), intent(inout) :: self
    if (c_associated(self%plan)) call fftw_destroy_plan(self%plan)
    self%plan = c_null_ptr
  end subroutine destroy

  subroutine transform_in_place(length, spectrum)
    !! Transform one record in place: the spectrum overwrites the samples.
    integer, intent(in) :: length                 !! N ≥ 1
    complex(dp), intent(inout), target, contiguous :: spectrum(:)   !! (N/2 + 1); in: its first N reals are the samples
    real(c_double), pointer, contiguous :: samples(:)
    type(c_ptr) :: plan
    call c_f_pointer(c_loc(spectrum), samples, [2*size(spectrum)])
    plan = fftw_plan_dft_r2c_1d(int(length, c_int), samples, spectrum, FFTW_ESTIMATE)
    call fftw_execute_dft_r2c(plan, samples, spectrum)
    call fftw_destroy_plan(plan)
  end subroutine transform_in_place

end module bw_fourier
