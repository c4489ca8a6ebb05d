module bw_reached_tolerance
  !! What a tolerance comes to where the run itself finds the number of modes: kept, missed, or, where it was not asked for, relaxed.
  use bw_case_result, only: case_done, case_not_converged, history_errors
  use bw_kinds, only: dp
  use bw_missing, only: is_missing
  use bw_modes_par, only: modes_par, relaxed_tolerance
  use bw_note, only: remark
  use bw_text, only: append, shortest, text_of
  implicit none (type, external)
  private
  public :: judge_tolerance

contains

  subroutine judge_tolerance(modes, reached, count, instead, errors)
    !! Say it, and in the status of the histories where a tolerance is missed.
    type(modes_par), intent(in) :: modes             !! with a tolerance
    real(dp), intent(in) :: reached                  !! the largest error over its peak
    integer, intent(in) :: count                     !! modes that were summed
    character(*), intent(in) :: instead              !! of a tolerance, what else would give histories
    type(history_errors), intent(inout) :: errors
    if (errors%status /= case_done .or. reached <= modes%tolerance) return
    if (modes%asked) then
      errors%status = case_not_converged
      call append(errors%notes, 'tolerance: '//shortest(modes%tolerance, 6)//' is missed with '//text_of(count)// &
                  ' modes; accepted: '//shortest(1.05_dp*reached, 2)//' or more, or before = '//text_of(count))
    else if (is_missing(relaxed_tolerance(reached))) then
      errors%status = case_not_converged
      call append(errors%notes, 'tolerance: none is reached with '//text_of(count)//' modes; accepted: '//instead// &
                  ', or before = '//text_of(count))
    else
      call remark(errors%notes, 'tolerance: the histories are found to '//shortest(relaxed_tolerance(reached), 6)//' of their '// &
                  'peaks; the default '//shortest(modes%tolerance, 6)//' is out of reach')
    end if
  end subroutine judge_tolerance

end module bw_reached_tolerance
