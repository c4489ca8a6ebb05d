module bw_line_or_colour
  !! Lines of a record, told from the colour of its noise: one that an autoregression of what is left would describe as well is none.
  !!
  !! Where the spectrum of the noise is steep its level is known badly, and a line that is taken out of the record takes the colour
  !! beside it along. So the noise is judged twice, with the line left in and taken out, each time with an autoregression of its own
  !! order: the logarithm of the ratio of their likelihoods is what the line pays.
  use bw_damped_line, only: add_uneven, damped_line, overlap, subtract_lines
  use bw_kinds, only: dp
  use bw_order, only: ascending
  use bw_samples, only: place_of, samples_type, span_of
  use bw_uneven_colour, only: judge_uneven_noise
  use bw_whitening, only: freedom_of_level, judge_noise, judged_order, whitening_type
  implicit none (type, external)
  private
  public :: are_lines, price_of, without_trend

  real(dp), parameter :: without_doubt = 15    !! times the threshold; no colour of the noise pays so much for a line
  real(dp), parameter :: beside_others = 200   !! the same behind a steep filter for one of several lines, which describe noise in a
                                               !! narrow band together
  real(dp), parameter :: reach = 8             !! bins, within which they do
  real(dp), parameter :: raised = 4            !! ordinates: where so many tell the noise's level a line must pay twice the threshold
  real(dp), parameter :: most_raised = 0.8_dp  !! beyond it

contains

  function are_lines(samples, steep, lines, pays, threshold) result(stays)
    !! Whether each of the lines pays more than the threshold. Those that pay without doubt by the level of the noise are
    !! taken out at once, and the others, while they pay, one after the other, the one that pays most first; but lines that share a
    !! peak are taken out together if they pay so, for one of two whose motions cancel leaves more than both. How well the level is
    !! known is asked of the colour without the line: left in, a line draws a resonance to it, whose level few ordinates tell. Nor
    !! do more ordinates tell it than there are below the line: noise may rise towards 0 as steeply as no autoregression does.
    type(samples_type), intent(in) :: samples
    logical, intent(in) :: steep               !! the noise is that of a steep filter
    type(damped_line), intent(in) :: lines(:)
    real(dp), intent(in) :: pays(:)            !! of each line over the noise's level, by which they are ordered
    real(dp), intent(in) :: threshold
    logical :: stays(size(lines))
    real(dp) :: left(samples%count, size(samples%value, 2)), without(samples%count, size(samples%value, 2))
    real(dp), dimension(size(samples%value, 2)) :: cost, cost_without
    type(whitening_type), dimension(size(samples%value, 2)) :: colour, colour_without
    real(dp) :: freedom, place(samples%count)
    logical :: tried(size(lines))
    integer :: order(size(lines)), highest(size(samples%value, 2)), i, k, n, s
    integer, allocatable :: peak(:)
    stays = pays > threshold*merge(beside_others, without_doubt, steep .and. [(is_beside_others(k), k=1, size(lines))])
    if (all(stays)) return
    place = [(place_of(samples, n), n=1, samples%count)]
    left = samples%value(:samples%count, :)
    without = left
    do s = 1, size(left, 2)
      call take_out(lines, s, without)
      if (.not. allocated(samples%place)) highest(s) = judged_order(without_trend(without(:, s), place))
      call take_out(pack(lines, stays), s, left)
      call judge(left, s, colour(s), cost(s))
    end do
    order = ascending(-pays)
    tried = stays
    do i = 1, size(lines)
      if (tried(order(i))) cycle
      peak = pack([(k, k=1, size(lines))], .not. tried .and. overlap(lines, lines(order(i)), span_of(samples)))
      tried(peak) = .true.
      call try(peak)
      if (stays(peak(1)) .or. size(peak) == 1) cycle
      peak = pack(order, [(any(peak == order(k)), k=1, size(lines))])
      do k = 1, size(peak)
        call try(peak(k:k))
      end do
    end do

  contains

    pure logical function is_beside_others(k)
      !! Whether another line is within reach of a line.
      integer, intent(in) :: k
      is_beside_others = count(abs(lines%frequency - lines(k)%frequency)*span_of(samples) < reach) > 1
    end function is_beside_others

    subroutine try(member)
      !! Take lines out if all of them together pay.
      integer, intent(in) :: member(:)
      without = left
      do s = 1, size(left, 2)
        call take_out(lines(member), s, without)
        call judge(without, s, colour_without(s), cost_without(s))
      end do
      freedom = minval([(freedom_of_level(colour_without(s), lines(member(1))%frequency, samples%count), s=1, size(colour))])
      freedom = min(freedom, lines(member(1))%frequency*span_of(samples))
      if (sum(cost - cost_without)/2 <= size(member)*threshold*(1 + min(most_raised, raised/freedom))) return
      stays(member) = .true.
      left = without
      cost = cost_without
      colour = colour_without
    end subroutine try

    subroutine take_out(some, s, value)
      !! Take lines out of the samples of one sensor.
      type(damped_line), intent(in) :: some(:)
      integer, intent(in) :: s
      real(dp), intent(inout) :: value(:, :)
      if (allocated(samples%place)) then
        call add_uneven(samples, some, s, -1.0_dp, value(:, s:s))
      else
        call subtract_lines(some, s, value(:, s))
      end if
    end subroutine take_out

    subroutine judge(value, s, colour, cost)
      !! Find the colour of what is left at one sensor, but for a straight line.
      real(dp), intent(in) :: value(:, :)
      integer, intent(in) :: s
      type(whitening_type), intent(out) :: colour
      real(dp), intent(out) :: cost
      if (allocated(samples%place)) then
        call judge_uneven_noise(without_trend(value(:, s), place), place, colour, cost)
      else
        call judge_noise(without_trend(value(:, s), place), highest(s), colour, cost)
      end if
    end subroutine judge

  end function are_lines

  real(dp) function price_of(samples, lines, threshold) result(price)
    !! What even samples cost: minus the logarithm of the likelihood of the noise that lines leave, and the threshold for each line.
    type(samples_type), intent(in) :: samples
    type(damped_line), intent(in) :: lines(:)
    real(dp), intent(in) :: threshold
    real(dp) :: left(samples%count, size(samples%value, 2)), cost
    type(whitening_type) :: colour
    integer :: n, s
    left = samples%value(:samples%count, :)
    price = threshold*size(lines)
    do s = 1, size(left, 2)
      call subtract_lines(lines, s, left(:, s))
      left(:, s) = without_trend(left(:, s), [(place_of(samples, n), n=1, samples%count)])
      call judge_noise(left(:, s), judged_order(left(:, s)), colour, cost)
      price = price + cost/2
    end do
  end function price_of

  pure function without_trend(value, place) result(left)
    !! Numbers less the straight line over their times that fits them best.
    real(dp), intent(in) :: value(:), place(:)
    real(dp) :: left(size(value)), u(size(value))
    u = place - sum(place)/size(place)
    left = value - sum(value)/size(value)
    left = left - u*(dot_product(u, left)/dot_product(u, u))
  end function without_trend

end module bw_line_or_colour
