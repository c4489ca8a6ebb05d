module bw_mode_cluster
  !! Modes whose frequencies agree to about all digits of binary64: several inverse iterations in double-double span their
  !! motions, and the quadratic forms of bw_mode_probe on that span (Rayleigh and Ritz) separate them.
  use bw_double_double, only: dd, operator(+)
  use bw_extended_mode, only: extended_motion
  use bw_kinds, only: dp
  use bw_mode_probe, only: driven, improve_drive, left_vector, mode_probe, piece_system, set_frequency, start_anew, weigh
  implicit none (type, external)
  private
  public :: separate, take

  integer, parameter :: rounds = 3               !! each divides by 100 what others show that are 100 times as far off

  type, public :: mode_cluster
    integer :: first = 0, last = -1              !! numbers of the modes
    type(dd), allocatable :: lambda(:)           !! λ, ascending
    real(dp), allocatable :: motion(:, :, :)     !! amplitudes, (4, pieces, modes)
    real(dp), allocatable :: drive(:, :, :, :)   !! what drives them, (3, 2, 0:pieces, modes)
  end type mode_cluster

  interface
    subroutine dsygv(itype, jobz, uplo, n, a, lda, b, ldb, w, work, lwork, info)
      import :: dp
      implicit none (type, external)
      integer, intent(in) :: itype, n, lda, ldb, lwork
      character, intent(in) :: jobz, uplo
      real(dp), intent(inout) :: a(lda, *), b(ldb, *)
      real(dp), intent(out) :: w(*), work(*)
      integer, intent(out) :: info
    end subroutine dsygv
  end interface

contains

  subroutine separate(system, lambda, first, last, probe, cluster)
    !! Modes next to a frequency, orthogonal to each other.
    type(piece_system), intent(in) :: system
    type(dd), intent(in) :: lambda
    integer, intent(in) :: first, last             !! their numbers
    type(mode_probe), intent(inout) :: probe
    type(mode_cluster), intent(out) :: cluster
    real(dp) :: drive(3, 2, 0:size(probe%ends), last - first + 1)
    integer :: i, round
    cluster%first = first
    cluster%last = last
    allocate (cluster%lambda(last - first + 1), cluster%motion(4, size(probe%ends), last - first + 1))
    allocate (cluster%drive(3, 2, 0:size(probe%ends), last - first + 1))
    do i = 1, last - first + 1
      call start_anew(i, probe)
      drive(:, :, :, i) = probe%drive
    end do
    do round = 1, rounds
      call find_span(system, lambda, drive, probe, cluster)
      do i = first, last
        call take(cluster, i, system, probe)
        drive(:, :, :, i - first + 1) = probe%drive
      end do
    end do
  end subroutine separate

  subroutine find_span(system, lambda, drive, probe, cluster)
    !! What so many drives give, mixed into modes.
    type(piece_system), intent(in) :: system
    type(dd), intent(in) :: lambda
    real(dp), intent(inout) :: drive(:, :, 0:, :)  !! of each; then of the modes
    type(mode_probe), intent(inout) :: probe
    type(mode_cluster), intent(inout) :: cluster
    real(dp) :: motion(4, size(probe%ends), size(drive, 4))
    real(dp), dimension(4, 0:size(probe%ends), size(drive, 4)) :: left, lack
    real(dp), dimension(size(drive, 4), size(drive, 4)) :: gram, form
    real(dp) :: correction(size(drive, 4)), work(8*size(drive, 4))
    integer :: i, j, n, info
    n = size(drive, 4)
    do i = 1, n
      probe%drive = drive(:, :, :, i)
      call extended_motion(system, lambda, probe)
      motion(:, :, i) = probe%amplitude/sqrt(probe%mass)
      left(:, :, i) = left_vector(system%beam, probe)/sqrt(probe%mass)
      lack(:, :, i) = driven(system%beam, probe)/sqrt(probe%mass)
      drive(:, :, :, i) = probe%drive/sqrt(probe%mass)
    end do
    do j = 1, n
      do i = 1, n
        form(i, j) = 0.5_dp*(sum(left(:, :, i)*lack(:, :, j)) + sum(left(:, :, j)*lack(:, :, i)))
        gram(i, j) = mass_product(system, probe, motion(:, :, [i, j]), drive(:, :, :, [i, j]))
      end do
    end do
    call dsygv(1, 'V', 'U', n, form, n, gram, n, correction, work, size(work), info)
    do j = 1, n
      cluster%lambda(j) = lambda + correction(j)
      cluster%motion(:, :, j) = 0.0_dp
      cluster%drive(:, :, :, j) = 0.0_dp
      do i = 1, n
        cluster%motion(:, :, j) = cluster%motion(:, :, j) + form(i, j)*motion(:, :, i)
        cluster%drive(:, :, :, j) = cluster%drive(:, :, :, j) + form(i, j)*drive(:, :, :, i)
      end do
    end do
  end subroutine find_span

  real(dp) function mass_product(system, probe, motion, drive) result(product)
    !! ⟨u, w⟩ from the masses of u + w and u − w.
    type(piece_system), intent(in) :: system
    type(mode_probe), intent(inout) :: probe
    real(dp), intent(in) :: motion(:, :, :)        !! amplitudes of u and w
    real(dp), intent(in) :: drive(:, :, 0:, :)     !! what drives them
    probe%amplitude = motion(:, :, 1) + motion(:, :, 2)
    probe%drive = drive(:, :, :, 1) + drive(:, :, :, 2)
    call weigh(system, probe)
    product = 0.25_dp*probe%mass
    probe%amplitude = motion(:, :, 1) - motion(:, :, 2)
    probe%drive = drive(:, :, :, 1) - drive(:, :, :, 2)
    call weigh(system, probe)
    product = product - 0.25_dp*probe%mass
  end function mass_product

  pure subroutine take(cluster, k, system, probe)
    !! Put a probe where mode k is.
    type(mode_cluster), intent(in) :: cluster
    integer, intent(in) :: k
    type(piece_system), intent(in) :: system
    type(mode_probe), intent(inout) :: probe
    call set_frequency(system, cluster%lambda(k - cluster%first + 1), probe)
    probe%amplitude = cluster%motion(:, :, k - cluster%first + 1)
    probe%drive = cluster%drive(:, :, :, k - cluster%first + 1)
    call weigh(system, probe)
    call improve_drive(probe)
  end subroutine take

end module bw_mode_cluster
