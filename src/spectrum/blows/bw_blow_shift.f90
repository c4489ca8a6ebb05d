module bw_blow_shift
  !! By how many samples a blow is best moved, with the lines and the motion that it adds unchanged.
  use bw_kinds, only: dp
  use bw_model, only: model_type
  implicit none (type, external)
  private
  public :: best_shift

  integer, parameter, public :: fewest = 16      !! fewest samples between blows
  integer, parameter, public :: near = 64        !! samples by which a blow may be wrong if found from prediction errors
  real(dp), parameter :: worth = 1               !! fall of −2 ln L for which a blow is moved

contains

  pure integer function best_shift(model, penalty, start, chosen, first, white, motion, at) result(shift)
    !! The move, in samples. A blow is not delayed past rows without information at any sensor, which may be clipped crests, nor
    !! past motion that exists in another phase, as that of a beat does: if none exists, the squares fall by those of the motion
    !! alone.
    type(model_type), intent(in) :: model
    real(dp), intent(in) :: penalty              !! of the blow's place, which it loses at …
    integer, intent(in) :: start                 !! … this sample
    integer, intent(in) :: chosen(:)             !! components
    integer, intent(in) :: first                 !! number of the first sample
    real(dp), intent(in) :: white(:, :)          !! prediction errors of the residual with this motion from sample `at` on
    real(dp), intent(in) :: motion(:, :)
    integer, intent(in) :: at
    real(dp), dimension(size(white, 1)) :: falls, taken
    real(dp) :: gain, best
    integer :: n, s
    falls = 0
    taken = 0
    do s = 1, size(white, 2)
      associate (filter => model%noise%filter(:model%noise%order(chosen(s)), chosen(s)))
        call add_falls(filter, known_rows(size(filter) - 1, model%missing(chosen(s))%place - first + 1, size(white, 1)), &
          white(:, s), motion(:, s), at, falls, taken)
      end associate
    end do
    shift = 0
    best = worth
    gain = 0
    do n = at - 1, 1, -1
      gain = gain + falls(n)
      if (n == start) gain = gain + penalty
      if (gain <= best) cycle
      best = gain
      shift = n - at
    end do
    gain = 0
    do n = at, size(white, 1) - fewest
      if (all(abs(white(n, :)) <= 0)) exit
      gain = gain + falls(n)
      if (n > at) taken(n) = taken(n - 1) + taken(n)
      if (gain <= best .or. (n - at >= near .and. abs(gain - taken(n)) > taken(n)/2)) cycle
      best = gain
      shift = n + 1 - at
    end do
  end function best_shift

  pure function known_rows(order, gaps, count) result(known)
    !! Which samples are predicted without a missing one.
    integer, intent(in) :: order                 !! p
    integer, intent(in) :: gaps(:)               !! missing samples
    integer, intent(in) :: count
    logical :: known(count)
    integer :: i
    known = .true.
    do i = 1, size(gaps)
      known(max(1, gaps(i) - order):min(count, gaps(i))) = .false.
    end do
  end function known_rows

  pure subroutine add_falls(filter, known, white, motion, at, falls, taken)
    !! Add by how much the squares of one component's prediction errors fall if the blow is moved past each sample, beginning with
    !! its neighbours: the motion there changes the error of this sample's prediction, and of those before it.
    real(dp), intent(in) :: filter(0:)           !! h
    logical, intent(in) :: known(:)
    real(dp), intent(in) :: white(:)
    real(dp), intent(in) :: motion(:)
    integer, intent(in) :: at
    real(dp), intent(inout) :: falls(:), taken(:)  !! taken: by how much the squares of the motion's own errors rise
    real(dp) :: change(ubound(filter, 1) + 1)
    real(dp), dimension(size(white)) :: seen, error
    integer :: i, n, first, side
    seen = merge(white, 0.0_dp, known)
    error = seen
    do i = 1, size(white)
      n = merge(at - i, i, i < at)               ! to the first sample, and from the blow on
      if (n == at) error = seen
      side = merge(-1, 1, n < at)                ! the motion is subtracted or added
      first = max(1, n - ubound(filter, 1))
      associate (e => error(first:n), c => change(:n - first + 1))
        c = merge(side*motion(n)*filter(n - first:0:-1), 0.0_dp, known(first:n))
        falls(n) = falls(n) - sum(c*(2*e + c))
        taken(n) = taken(n) + sum(c*(2*(e - seen(first:n)) + c))
        e = e + c
      end associate
    end do
  end subroutine add_falls

end module bw_blow_shift
