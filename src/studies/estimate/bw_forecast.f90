module bw_forecast
  !! Warnings expected of a run: the notes of its first and last case or, if these take too long, of runs with few modes
  !! and samples.
  use bw_case_cost, only: case_bytes, case_counts, seconds_of
  use bw_case_result, only: case_result
  use bw_error, only: error_type
  use bw_kinds, only: dp, i8
  use bw_missing, only: missing
  use bw_monitor, only: monitor_type
  use bw_note, only: kind_of
  use bw_notes, only: notes_type
  use bw_one_case, only: case_cache, run_case
  use bw_result_layout, only: result_layout
  use bw_scene, only: scene_type
  use bw_scene_cases, only: case_count, case_scene
  use bw_stopwatch, only: stopwatch
  use bw_text, only: append, string
  implicit none (type, external)
  private
  public :: forecast_notes, takes_at_most

  integer, parameter, public :: few_modes = 20, few_samples = 1000      !! of a predicted case
  real(dp), parameter :: quick = 0.03_dp                     !! s: a case this short is run unchanged
  real(dp), parameter :: most_seconds = 0.5_dp               !! s, with few modes
  integer(i8), parameter :: most_bytes = 1000000000_i8       !! of memory

  type, public :: forecast_type
    type(notes_type) :: notes
    integer :: cases = 0                           !! that were tried
    logical :: from_few = .false.                  !! with few modes and samples
  end type forecast_type

contains

  logical function takes_at_most(scene, planned, seconds) result(quickly)
    !! Return whether a case takes at most so many seconds by the cost model.
    type(scene_type), intent(in) :: scene          !! without sweeps
    integer, intent(in) :: planned                 !! modes that a tolerance needs
    real(dp), intent(in) :: seconds
    quickly = seconds_of(case_counts(scene, planned)) <= seconds .and. case_bytes(scene) <= most_bytes
  end function takes_at_most

  subroutine forecast_notes(scene, layout, planned, monitor, forecast)
    !! Predict the notes of the first and the last case of a sweep, since extremes are often last.
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    integer, intent(in) :: planned                 !! as in `takes_at_most`
    class(monitor_type), intent(inout) :: monitor  !! nothing is known if it asks to stop
    type(forecast_type), intent(out) :: forecast
    type(scene_type) :: one
    type(error_type), allocatable :: error
    type(string), allocatable :: notes(:)
    integer(i8) :: index, cases
    cases = case_count(scene)
    do index = 1, cases, max(1_i8, cases - 1)
      call case_scene(scene, index, one, error)
      if (allocated(error)) cycle
      allocate (notes(0))
      if (takes_at_most(one, planned, quick)) then
        call try(one, layout, monitor, '', notes)
      else if (takes_at_most(few_of(one, 1.0_dp), few_modes, most_seconds)) then
        forecast%from_few = .true.
        call try(few_of(one, 1.0_dp), layout, monitor, 'of modes', notes)
        if (allocated(one%response)) &
          call try(few_of(one, real(few_samples, dp)/one%response%samples), layout, monitor, 'of samples', notes)
      else
        return
      end if
      if (monitor%stop_requested()) return
      call forecast%notes%add(index, notes)
      forecast%cases = forecast%cases + 1
      deallocate (notes)
    end do
  end subroutine forecast_notes

  subroutine try(scene, layout, monitor, kinds, notes)
    !! Run a case and take its notes: all of them or, with few modes, either those on the sampling rate or the others. Few modes
    !! would raise errors and hide where energy goes. Spectra are omitted: their time is hard to predict and they warn of little.
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    class(monitor_type), intent(inout) :: monitor
    character(*), intent(in) :: kinds
    type(string), allocatable, intent(inout) :: notes(:)
    type(scene_type) :: simple
    type(case_result) :: result
    type(stopwatch) :: watch
    type(case_cache), target :: cache
    character(:), allocatable :: kind
    integer :: i
    logical :: whole
    simple = scene
    if (allocated(simple%spectrum)) deallocate (simple%spectrum)
    simple%modes%modal_model = .false.              ! it causes no warnings
    call run_case(simple, layout, watch, monitor, cache, result, whole)
    if (.not. whole) return
    do i = 1, size(result%notes)
      kind = kind_of(result%notes(i)%text)
      if (kinds /= '' .and. (index(kind, 'error of') == 1 .or. kind == 'energy of the release')) cycle
      if (kinds /= '' .and. ((kind == 'aliasing' .or. kind == 'sampling') .neqv. (kinds == 'of samples'))) cycle
      call append(notes, result%notes(i)%text)
    end do
  end subroutine try

  pure function few_of(scene, part) result(few)
    !! Return a scene of few modes and samples, without later contacts.
    type(scene_type), intent(in) :: scene
    real(dp), intent(in) :: part                   !! of the record
    type(scene_type) :: few
    few = scene
    few%modes%tolerance = missing
    few%modes%before = few_modes
    if (scene%modes%before > 0) few%modes%before = min(few_modes, scene%modes%before)
    few%modes%after = min(few_modes, scene%modes%after)
    if (allocated(few%recontact)) deallocate (few%recontact)
    if (.not. allocated(few%response)) return
    if (part < 1.0_dp) few%response%duration = part*scene%response%duration
    few%response%samples = min(few_samples, scene%response%samples)
  end function few_of

end module bw_forecast
