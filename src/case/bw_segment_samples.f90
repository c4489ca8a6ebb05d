module bw_segment_samples
  !! Which samples of a record show a segment of the motion.
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
    !! Samples, numbered from 1, of a motion that starts at a time.
    type(time_grid), intent(in) :: grid
    integer, intent(in) :: first, last
    type(dd), intent(in) :: start                !! l²/h
    stretch = stretch_type(max(0.0_dp, (first - 1)*grid%step%hi - start%hi), last*grid%step%hi - start%hi, grid%step%hi)
  end function stretch_of

  pure function samples_of_segment(motion, i, grid) result(samples)
    !! The first and the last of a segment, numbered from 1: a sample at exactly the time of a change belongs to what comes after it.
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
