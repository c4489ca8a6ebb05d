module bw_case_result
  !! Everything that one case yields, and what its stages hand to each other: each stage takes the values of those before it
  !! and returns its own.
  use bw_beam_units, only: beam_units
  use bw_double_double, only: dd
  use bw_error, only: error_type
  use bw_event, only: event_type
  use bw_impact, only: impact_type
  use bw_initial_state, only: initial_state
  use bw_kinds, only: dp
  use bw_measured, only: measured_type
  use bw_missing, only: missing
  use bw_mode_set, only: mode_set, mode_sources
  use bw_record, only: record_extent
  use bw_record_lines, only: record_lines
  use bw_release, only: tip_remainder
  use bw_response, only: response_type
  use bw_segment, only: segment_type
  use bw_text, only: append, string
  implicit none (type, external)
  private
  public :: add_notes

  integer, parameter, public :: case_done = 0, case_diverged = 1, case_not_converged = 2, case_ill_conditioned = 3, &
    case_misfit = 4
  character(*), parameter, public :: case_words(0:4) = &
    [character(15) :: 'done', 'diverged', 'not_converged', 'ill_conditioned', 'misfit']   !! by number

  type, public :: case_modes
    !! The sets of modes that are in memory: those that move, or the first of them where a tolerance says how many.
    class(mode_set), allocatable :: free            !! of the beam alone; unallocated with a tolerance
    class(mode_set), allocatable :: loaded          !! of beam and mass; unallocated: the mass is not captured
    logical :: can_grow = .true.                    !! there may be an angular velocity at which a mode does
    logical :: resolved = .true.                    !! false: their numbers mean nothing, and nothing follows from them
    type(string), allocatable :: notes(:)
  end type case_modes

  type, public :: release_plan
    type(dd) :: time                                !! when the mass leaves, l²/h
    integer :: count = 0                            !! modes of the beam alone that move after it
    type(tip_remainder) :: tip                           !! what modes that are not summed add then, with a tolerance
  end type release_plan

  type, public :: case_plan
    !! How many modes are summed, settled before any history is.
    integer :: count = 0                            !! modes that move after t = 0, before a release
    type(release_plan), allocatable :: release      !! unallocated where none comes within the record
    real(dp) :: reached = 0.0_dp                    !! with a tolerance: the estimated error of the displacement over its peak
  end type case_plan

  type, public :: case_events
    !! What happens in the record, and the motion in between.
    type(event_type), allocatable :: events(:)      !! in the order of time
    type(segment_type), allocatable :: segments(:)  !! between events; unallocated where there is none at t > 0
    class(mode_set), allocatable :: in_contact      !! modes of beam and mass while the mass is pressed against the tip
    class(mode_set), allocatable :: released        !! modes that move after a release, where a tolerance says how many
    real(dp) :: known_until = huge(1.0_dp)          !! l²/h; from then on contacts leave nothing of the motion that is known
    integer :: ending = case_done                   !! why so, as a status
    type(string), allocatable :: notes(:)
  end type case_events

  type, public :: case_motion
    !! All that is settled of a case before its histories are summed.
    type(beam_units) :: units
    type(case_modes) :: modes
    type(mode_sources) :: sources
    type(case_plan) :: plan
    type(initial_state) :: initial
    type(case_events) :: later
  end type case_motion

  type, public :: case_histories
    type(response_type), allocatable :: response    !! SI; unallocated where no history is asked for
    integer :: status = case_done
    type(string), allocatable :: notes(:)
  end type case_histories

  type, public :: history_errors
    !! Estimates of the largest error of the histories; unallocated where there is none.
    real(dp), allocatable :: displacement(:)        !! m, (points)
    real(dp), allocatable :: velocity(:)            !! m/s, (points)
    real(dp), allocatable :: bending_moment(:)      !! N m, (points)
    integer :: status = case_done                   !! of the case, these errors considered
    type(string), allocatable :: notes(:)
  end type history_errors

  type, public :: case_spectrum
    real(dp), allocatable :: amplitude(:, :)        !! m, (frequencies, points)
    type(measured_type), allocatable :: measured    !! waves, SI
    type(string), allocatable :: notes(:)
  end type case_spectrum

  type, public :: record_result
    !! What a record yields beside frequencies and waves, SI.
    type(record_extent) :: extent
    type(record_lines) :: lines
    real(dp), allocatable :: recorded(:, :), fitted(:, :)   !! at the times that are drawn, (times, sensors)
    real(dp), allocatable :: noise(:, :)                    !! what noise makes of the amplitude spectrum, (frequencies, sensors)
    real(dp) :: stiffness_root(2) = missing                 !! √(EI/ρA) from the dispersion, and half its interval, m²/s
    real(dp) :: angular_velocity(2) = missing               !! |ω| from it, rad/s
  end type record_result

  type, public :: case_result
    !! An unallocated component was not asked for.
    type(beam_units) :: units
    class(mode_set), allocatable :: modes             !! in force after t = 0, or the first of them
    integer :: mode_count = 0                         !! how many were summed
    real(dp) :: reached = 0.0_dp                      !! with a tolerance: the estimated error of the displacement over its peak
    integer :: profile_points = 0                     !! places along the beam of mode shapes and velocity jump; 0: of neither
    class(mode_set), allocatable :: before            !! of the beam alone, if the mass was captured
    logical :: can_grow = .false.                     !! there may be an angular velocity at which a mode does
    type(impact_type), allocatable :: impact
    real(dp) :: approach_velocity = 0.0_dp            !! V, m/s
    real(dp), allocatable :: modal_velocity(:)        !! state after the last event at t = 0, in V, (modes)
    real(dp), allocatable :: velocity_jump(:)         !! Σφ_iΔq̇_i along the beam, in V, (profile)
    type(event_type), allocatable :: events(:)        !! in the order of time
    type(release_plan), allocatable :: release        !! within the record
    type(response_type), allocatable :: response      !! SI
    real(dp), allocatable :: amplitude(:, :)          !! m, (frequencies, points)
    type(measured_type), allocatable :: measured      !! SI
    type(record_result), allocatable :: record        !! of a record
    integer :: status = case_done
    type(string), allocatable :: notes(:)             !! warnings and remarks (bw_note)
    type(error_type), allocatable :: error            !! why there is no result: a record cannot be read
  end type case_result

contains

  pure subroutine add_notes(notes, more)
    !! The notes of a stage, after those of the stages before it.
    type(string), allocatable, intent(inout) :: notes(:)
    type(string), intent(in), optional :: more(:)    !! absent: the stage has none
    integer :: i
    if (.not. present(more)) return
    do i = 1, size(more)
      call append(notes, more(i)%text)
    end do
  end subroutine add_notes

end module bw_case_result
