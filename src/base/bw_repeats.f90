module bw_repeats
  !! Seconds of work that is done again and again: the median, and the quarter below and above it. On a busy machine
  !! single times are late by any amount; half of them are not.
  use bw_kinds, only: dp
  use bw_missing, only: missing
  implicit none (type, external)
  private

  type, public :: repeats_type
    integer :: count = 0
    real(dp), allocatable :: seconds(:)      !! ascending, (count)
  contains
    procedure :: add
    procedure :: total
    procedure :: quantile
    procedure :: median
  end type repeats_type

contains

  pure subroutine add(self, seconds)
    class(repeats_type), intent(inout) :: self
    real(dp), intent(in) :: seconds
    integer :: below
    if (.not. allocated(self%seconds)) allocate (self%seconds(0))
    below = count(self%seconds < seconds)
    self%seconds = [self%seconds(:below), seconds, self%seconds(below + 1:)]
    self%count = self%count + 1
  end subroutine add

  pure real(dp) function total(self)
    class(repeats_type), intent(in) :: self
    total = 0.0_dp
    if (self%count > 0) total = sum(self%seconds)
  end function total

  pure real(dp) function median(self)
    class(repeats_type), intent(in) :: self
    median = self%quantile(0.5_dp)
  end function median

  pure real(dp) function quantile(self, part)
    !! The time that this part of all stays below, between neighbours by the straight line; missing where there is none.
    class(repeats_type), intent(in) :: self
    real(dp), intent(in) :: part             !! 0 … 1
    real(dp) :: place
    integer :: below
    quantile = missing
    if (self%count == 0) return
    place = 1.0_dp + part*(self%count - 1)
    below = min(int(place), self%count)
    quantile = self%seconds(below)
    if (below < self%count) quantile = quantile + (place - below)*(self%seconds(below + 1) - self%seconds(below))
  end function quantile

end module bw_repeats
