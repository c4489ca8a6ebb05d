module bw_forecast
  !! What a run of a scene would say, before it is run: the notes of cases that were tried, or, of a case that takes longer than
  !! there is time, those of few of its modes and samples.
  use bw_case_result, only: case_result
  use bw_case_shares, only: case_bytes
  use bw_kinds, only: dp, i8
  use bw_missing, only: missing
  use bw_modes_par, only: by_tolerance
  use bw_monitor, only: monitor_type
  use bw_note, only: kind_of
  use bw_notes, only: notes_type
  use bw_one_case, only: case_cache, run_case
  use bw_result_layout, only: result_layout
  use bw_scene, only: scene_type
  use bw_stopwatch, only: stopwatch
  use bw_text, only: append, string
  implicit none (type, external)
  private

  integer, parameter, public :: few_modes = 20, few_samples = 1000      !! of a case that is predicted
  integer(i8), parameter, public :: most_trial_bytes = 1000000000_i8    !! of memory, which a case that is tried may take

  type, public :: forecast_type
    !! What cases that were run for their time had to say.
    type(notes_type) :: notes
    integer(i8), allocatable :: cases(:)      !! their numbers
    logical :: from_few = .false.             !! there was no time to run any case to its end
  contains
    procedure :: add
    procedure :: predict_notes
  end type forecast_type

contains

  subroutine add(self, index, notes)
    !! Keep the notes of a case, once.
    class(forecast_type), intent(inout) :: self
    integer(i8), intent(in) :: index              !! of the case
    type(string), intent(in) :: notes(:)
    if (any(self%cases == index)) return
    self%cases = [self%cases, index]
    call self%notes%add(index, notes)
  end subroutine add

  subroutine predict_notes(self, index, scene, layout, monitor)
    !! The notes of a case that takes longer than there is time, from few of its modes and samples: from samples of its whole record,
    !! and from its first ones, which are as close to each other as those of the case.
    class(forecast_type), intent(inout) :: self
    integer(i8), intent(in) :: index              !! of the case
    type(scene_type), intent(in) :: scene         !! of the case
    type(result_layout), intent(in) :: layout
    class(monitor_type), intent(inout) :: monitor !! nothing is predicted where it asks to stop
    type(case_result) :: result
    type(string), allocatable :: notes(:)
    type(scene_type) :: few
    logical :: whole
    allocate (notes(0))
    few = few_of(scene, 1.0_dp)
    if (case_bytes(few) > most_trial_bytes) return
    call run_few(few, layout, monitor, result, whole)
    if (.not. whole) return
    call take_notes(result%notes, .false., notes)
    if (allocated(scene%response)) then
      few = few_of(scene, real(few_samples, dp)/scene%response%samples)
      call run_few(few, layout, monitor, result, whole)
      if (.not. whole) return
      call take_notes(result%notes, .true., notes)
    end if
    self%from_few = self%from_few .or. size(self%cases) == 0
    call self%add(index, notes)
  end subroutine predict_notes

  subroutine run_few(few, layout, monitor, result, whole)
    !! Run the short case to its end, if the user lets it.
    type(scene_type), intent(in) :: few
    type(result_layout), intent(in) :: layout
    class(monitor_type), intent(inout) :: monitor
    type(case_result), intent(out) :: result
    logical, intent(out) :: whole
    type(stopwatch) :: watch
    type(case_cache), target :: cache
    call run_case(few, layout, watch, monitor, cache, result, whole)
  end subroutine run_few

  pure subroutine take_notes(found, aliasing, notes)
    !! Of samples that are close to each other the note on aliasing, of the others all but that; none on errors, which few modes
    !! would raise, nor on where the energy goes, of which few modes know less than a run.
    type(string), intent(in) :: found(:)
    logical, intent(in) :: aliasing
    type(string), allocatable, intent(inout) :: notes(:)
    character(:), allocatable :: kind
    integer :: i
    do i = 1, size(found)
      kind = kind_of(found(i)%text)
      if (index(kind, 'error of') == 1 .or. kind == 'energy of the release') cycle
      if ((kind == 'aliasing') .eqv. aliasing) call append(notes, found(i)%text)
    end do
  end subroutine take_notes

  pure function few_of(scene, part) result(few)
    !! A scene of few modes and samples, without later contacts and spectrum.
    type(scene_type), intent(in) :: scene
    real(dp), intent(in) :: part                  !! of the record
    type(scene_type) :: few
    few = scene
    few%modes%tolerance = missing
    few%modes%before = few_modes
    few%modes%after = few_modes
    if (scene%modes%before > 0) few%modes%before = min(few_modes, scene%modes%before)
    if (.not. by_tolerance(scene%modes)) few%modes%after = min(few_modes, scene%modes%after)
    if (allocated(few%recontact)) deallocate (few%recontact)
    if (allocated(few%spectrum)) deallocate (few%spectrum)
    if (.not. allocated(few%response)) return
    if (part < 1.0_dp) few%response%duration = part*scene%response%duration
    few%response%samples = min(few_samples, scene%response%samples)
  end function few_of

end module bw_forecast
