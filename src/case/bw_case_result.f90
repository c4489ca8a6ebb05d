module bw_case_result
  !! Everything that one case yields, as the rooms before this one hand it over.
  use bw_kinds, only: dp
  use bw_beam_units, only: beam_units
  use bw_course, only: course_type
  use bw_event, only: event_type
  use bw_impact, only: impact_type
  use bw_measured, only: measured_type
  use bw_mode_set, only: mode_set
  use bw_release, only: tip_rest
  use bw_response, only: response_type
  use bw_text, only: append, string
  implicit none (type, external)
  private
  public :: add_note

  integer, parameter, public :: case_done = 0, case_diverged = 1, case_not_converged = 2, case_ill_conditioned = 3
  character(*), parameter, public :: case_words(0:3) = &
    [character(15) :: 'done', 'diverged', 'not_converged', 'ill_conditioned']   !! by number

  type, public :: case_result
    !! An unallocated component was not asked for.
    type(beam_units) :: units
    class(mode_set), allocatable :: modes             !! in force after t = 0, or the first of them
    integer :: mode_count = 0                         !! how many were summed
    class(mode_set), allocatable :: before            !! of the unloaded beam, if the mass was captured
    logical :: can_grow = .false.                     !! there may be an angular velocity at which a mode does
    type(impact_type), allocatable :: impact
    real(dp) :: approach_velocity = 0.0_dp            !! V, m/s
    real(dp), allocatable :: modal_velocity(:)        !! state after the last event at t = 0, in V, (modes)
    real(dp), allocatable :: velocity_jump(:)         !! Σφ_iΔq̇_i along the beam, in V, (profile)
    type(event_type), allocatable :: events(:)        !! in the order of time
    type(course_type), allocatable :: courses(:)      !! between events; where there is none at t > 0, the motion is one
    type(tip_rest), allocatable :: tip_rest           !! of a release, where a tolerance asks for as many modes as it takes
    integer :: released_count = 0                     !! modes of the unloaded beam after it, likewise
    class(mode_set), allocatable :: held              !! modes of beam and mass while the mass is pressed against the tip
    real(dp) :: known_until = huge(1.0_dp)            !! l²/h; from then on contacts leave nothing of the motion that is known
    integer :: ending = case_done                     !! why so, as a status
    type(response_type), allocatable :: response      !! SI
    real(dp), allocatable :: amplitude(:, :)          !! m, (frequencies, points)
    type(measured_type), allocatable :: measured      !! SI
    integer :: status = case_done
    type(string), allocatable :: notes(:)             !! what the report warns of
  end type case_result

contains

  pure subroutine add_note(result, text)
    !! One more warning of a case.
    type(case_result), intent(inout) :: result
    character(*), intent(in) :: text      !! what stands before its first colon is its kind
    call append(result%notes, text)
  end subroutine add_note

end module bw_case_result
