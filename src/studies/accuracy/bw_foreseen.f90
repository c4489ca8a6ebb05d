module bw_foreseen
  !! How long the next of a row of runs will take, each finer than the one before.
  use bw_kinds, only: dp
  implicit none (type, external)
  private

  type, public :: foresight
    !! The last two runs: seconds are taken to go on as a power of what makes runs finer.
    private
    real(dp) :: size(2) = 0.0_dp                 !! number of modes, or the inverse of the tolerance
    real(dp) :: seconds(2) = 0.0_dp              !! 0: no such run
  contains
    procedure :: book
    procedure :: next_seconds
  end type foresight

contains

  elemental subroutine book(self, size, seconds)
    !! Another run.
    class(foresight), intent(inout) :: self
    real(dp), intent(in) :: size                 !! above that of the run before
    real(dp), intent(in) :: seconds
    self%size = [self%size(2), size]
    self%seconds = [self%seconds(2), seconds]
  end subroutine book

  elemental real(dp) function next_seconds(self, size, steepest) result(seconds)
    !! Of a run of that size; 0 where no run is known.
    class(foresight), intent(in) :: self
    real(dp), intent(in) :: size                 !! above those of the runs
    real(dp), intent(in) :: steepest             !! the largest power: first runs find cold caches, which are no trend
    real(dp) :: power
    seconds = self%seconds(2)
    if (any(self%seconds <= 0.0_dp)) return
    power = log(self%seconds(2)/self%seconds(1))/log(self%size(2)/self%size(1))
    seconds = seconds*(size/self%size(2))**max(0.0_dp, min(steepest, power))
  end function next_seconds

end module bw_foreseen
