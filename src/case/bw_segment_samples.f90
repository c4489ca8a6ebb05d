module bw_segment_samples
  !! The samples of a record that lie in a segment of the motion.
  use bw_case_result, only: case_motion
  use bw_double_double, only: dd
  use bw_kinds, only: dp
  use bw_reach, only: stretch_type
  use bw_time_grid, only: first_sample, time_grid
  implicit none (type, external)
  private
  public :: samples_of_segment, stretch_of

contains

  pure type(stretch_type) function stretch_of(grid, first, last, start) result(stretch)
    !! Return the times of samples `first` to `last` since a motion's start.
    type(time_grid), intent(in) :: grid
    integer, intent(in) :: first, last
    type(dd), intent(in) :: start                !! l²/h
    stretch = stretch_type(max(0.0_dp, (first - 1)*grid%step%hi - start%hi), last*grid%step%hi - start%hi, grid%step%hi)
  end function stretch_of

  pure function samples_of_segment(motion, i, grid) result(samples)
    !! Return the first and the last sample of a segment, from 1. A sample exactly at a change belongs to the segment after it.
    type(case_motion), intent(in) :: motion
    integer, intent(in) :: i
    type(time_grid), intent(in) :: grid
    integer :: samples(2)
    associate (segments => motion%timeline%segments)
      samples = [first_sample(segments(i)%start, grid), grid%samples]
      if (i < size(segments)) samples(2) = first_sample(segments(i + 1)%start, grid) - 1
    end associate
  end function samples_of_segment

end module bw_segment_samples
