module bw_mode_cluster
  !! Modes whose frequencies agree to about all digits: several inverse iterations span their motions, and the quadratic
  !! forms of bw_mode_probe on that span (Rayleigh and Ritz) separate them.
  use bw_double_double, only: dd
  use bw_kinds, only: dp
  use bw_joint_elimination, only: solve
  use bw_mode_probe, only: mode_probe, piece_system, probe_at, start_anew, weigh
  implicit none (type, external)
  private
  public :: separate

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

  subroutine separate(system, lambda, modes, which, probe, correction)
    !! The motion of one of several modes next to a frequency, orthogonal to the others', and by how much its λ differs.
    type(piece_system), intent(in) :: system
    type(dd), intent(in) :: lambda
    integer, intent(in) :: modes                   !! how many there are
    integer, intent(in) :: which                   !! 1 … modes, in the order of their frequencies
    type(mode_probe), intent(inout) :: probe
    real(dp), intent(out) :: correction
    real(dp) :: motion(4, size(probe%ends), modes)
    real(dp) :: left(4, 0:size(probe%ends), modes), lack(4, 0:size(probe%ends), modes)
    real(dp) :: gram(modes, modes), form(modes, modes), square(modes), work(8*modes)
    integer :: i, j, info
    do i = 1, modes
      call start_anew(system, i, probe)
      call probe_at(system, lambda, probe)
      call solve(probe%factors, probe%amplitude)
      call weigh(system, probe, left(:, :, i))
      motion(:, :, i) = probe%amplitude/sqrt(probe%mass)
      left(:, :, i) = left(:, :, i)/sqrt(probe%mass)
      lack(:, :, i) = probe%drive*probe%unit/sqrt(probe%mass)
    end do
    do j = 1, modes
      do i = 1, modes
        form(i, j) = 0.5_dp*(sum(left(:, :, i)*lack(:, :, j)) + sum(left(:, :, j)*lack(:, :, i)))
        gram(i, j) = product_of(motion(:, :, i), motion(:, :, j))
      end do
    end do
    call dsygv(1, 'V', 'U', modes, form, modes, gram, modes, square, work, size(work), info)
    correction = square(which)
    probe%amplitude = 0.0_dp
    do i = 1, modes
      probe%amplitude = probe%amplitude + form(i, which)*motion(:, :, i)
    end do
    call weigh(system, probe, left(:, :, 1))
  contains
    real(dp) function product_of(one, other)
      !! ⟨u, w⟩ from the masses of u + w and u − w.
      real(dp), intent(in) :: one(:, :), other(:, :)
      real(dp) :: ignored(4, 0:size(probe%ends))
      probe%amplitude = one + other
      call weigh(system, probe, ignored)
      product_of = 0.25_dp*probe%mass
      probe%amplitude = one - other
      call weigh(system, probe, ignored)
      product_of = product_of - 0.25_dp*probe%mass
    end function product_of
  end subroutine separate

end module bw_mode_cluster
