module bw_line_or_colour
  !! Lines of a record, told from the colour of its noise: one that an autoregression of what is left would describe as well is none.
  !!
  !! Where the spectrum of the noise is steep its level is known badly, and a line that is taken out of the record takes the colour
  !! beside it along. So the noise is judged twice, with the line left in and taken out, each time with an autoregression of its own
  !! order: the logarithm of the ratio of their likelihoods is what the line pays.
  use bw_damped_line, only: damped_line, overlap, subtract_lines
  use bw_kinds, only: dp
  use bw_order, only: ascending
  use bw_samples, only: samples_type
  use bw_whitening, only: freedom_of_level, judge_noise, judged_order, whitening_type
  implicit none (type, external)
  private
  public :: are_lines, without_trend

  real(dp), parameter :: without_doubt = 15    !! times the threshold; no colour of the noise pays so much
  real(dp), parameter :: raised = 4            !! ordinates: where so many tell the noise's level a line must pay twice the threshold
  real(dp), parameter :: most_raised = 0.8_dp  !! beyond it

contains

  function are_lines(samples, lines, pays, threshold) result(stays)
    !! Whether each of the lines of even samples pays more than the threshold. Those that pay enough by the level of the noise are
    !! taken out at once, and the others, while they pay, one after the other, the one that pays most first; but lines that share a
    !! peak are taken out together if they pay so, for one of two whose motions cancel leaves more than both. How well the level is
    !! known is asked of the colour without the line: left in, a line draws a resonance to it, whose level few ordinates tell.
    type(samples_type), intent(in) :: samples
    type(damped_line), intent(in) :: lines(:)
    real(dp), intent(in) :: pays(:)            !! of each line over the noise's level, by which they are ordered
    real(dp), intent(in) :: threshold
    logical :: stays(size(lines))
    real(dp) :: left(samples%count, size(samples%value, 2)), without(samples%count, size(samples%value, 2))
    real(dp), dimension(size(samples%value, 2)) :: cost, cost_without
    type(whitening_type), dimension(size(samples%value, 2)) :: colour, colour_without
    real(dp) :: freedom
    logical :: tried(size(lines))
    integer :: order(size(lines)), highest(size(samples%value, 2)), i, k, s
    integer, allocatable :: peak(:)
    stays = pays > without_doubt*threshold
    if (all(stays)) return
    left = samples%value(:samples%count, :)
    do s = 1, size(left, 2)
      without(:, s) = left(:, s)
      call subtract_lines(lines, s, without(:, s))
      highest(s) = judged_order(without_trend(without(:, s)))
      call subtract_lines(pack(lines, stays), s, left(:, s))
      call judge_noise(without_trend(left(:, s)), highest(s), colour(s), cost(s))
    end do
    order = ascending(-pays)
    tried = stays
    do i = count(stays) + 1, size(lines)
      if (tried(order(i))) cycle
      peak = pack([(k, k=1, size(lines))], .not. tried .and. overlap(lines, lines(order(i)), real(samples%count, dp)))
      tried(peak) = .true.
      call try(peak)
      if (stays(peak(1)) .or. size(peak) == 1) cycle
      peak = pack(order, [(any(peak == order(k)), k=1, size(lines))])
      do k = 1, size(peak)
        call try(peak(k:k))
      end do
    end do

  contains

    subroutine try(member)
      !! Take lines out if all of them together pay.
      integer, intent(in) :: member(:)
      without = left
      do s = 1, size(left, 2)
        call subtract_lines(lines(member), s, without(:, s))
        call judge_noise(without_trend(without(:, s)), highest(s), colour_without(s), cost_without(s))
      end do
      freedom = minval([(freedom_of_level(colour_without(s), lines(member(1))%frequency, samples%count), s=1, size(colour))])
      if (sum(cost - cost_without)/2 <= size(member)*threshold*(1 + min(most_raised, raised/freedom))) return
      stays(member) = .true.
      left = without
      cost = cost_without
      colour = colour_without
    end subroutine try

  end function are_lines

  pure function without_trend(value) result(left)
    !! Numbers less the straight line that fits them best.
    real(dp), intent(in) :: value(:)
    real(dp) :: left(size(value)), u(size(value))
    integer :: n
    u = [(n - (size(value) + 1)/2.0_dp, n=1, size(value))]
    left = value - sum(value)/size(value)
    left = left - u*(dot_product(u, left)/dot_product(u, u))
  end function without_trend

end module bw_line_or_colour
