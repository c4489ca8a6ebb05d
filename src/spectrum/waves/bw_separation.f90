module bw_separation
  !! Decorrelation of numbers with known correlations.
  use bw_kinds, only: dp
  use bw_lapack, only: dsyev
  use bw_missing, only: no_number
  implicit none (type, external)
  private
  public :: separation_of

  real(dp), parameter :: least = 1.0e-3_dp     !! least eigenvalue that is used, of S in all (all but 1/30 is shared)

contains

  function separation_of(correlation) result(separating)
    !! The symmetric matrix that turns numbers with these correlations into independent ones of the same variance.
    real(dp), intent(in) :: correlation(:, :)
    real(dp), dimension(size(correlation, 1), size(correlation, 2)) :: separating, vectors
    real(dp) :: values(size(correlation, 1)), work(64*size(correlation, 1))
    integer :: s, info
    vectors = correlation
    call dsyev('V', 'U', size(values), vectors, size(values), values, work, size(work), info)
    if (info /= 0) values = no_number()
    do s = 1, size(values)
      separating(:, s) = vectors(:, s)/sqrt(max(values(s), least))
    end do
    separating = matmul(separating, transpose(vectors))
  end function separation_of

end module bw_separation
