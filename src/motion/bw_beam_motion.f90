module bw_beam_motion
  !! The motion of a beam: its modes in every configuration, its initial state and its timeline.
  use bw_beam_units, only: beam_units
  use bw_force_step, only: step_end
  use bw_initial_state, only: initial_state
  use bw_mode_set, only: configuration_type
  use bw_segment, only: alone
  use bw_text, only: string
  use bw_timeline, only: timeline_type
  implicit none (type, external)
  private

  type, public :: case_modes
    !! Sources of modes and the modes held in memory: those that move, or the first few if a tolerance chooses the number.
    type(configuration_type), allocatable :: configuration(:)   !! those of `configurations_of` (bw_timeline)
    integer :: moving = alone                       !! configuration after t = 0
    logical :: can_grow = .true.                    !! a mode may be unstable at some angular velocity
    logical :: resolved = .true.                    !! false: modes are invalid, and nothing is computed from them
    type(string), allocatable :: notes(:)
  end type case_modes

  type, public :: beam_motion
    !! What is known of a beam's motion. Units of bw_segment.
    type(beam_units) :: units
    type(case_modes) :: modes
    logical :: of_continuum = .false.               !! a captured mass strikes infinitely many modes, not those held
    type(initial_state) :: initial
    type(timeline_type) :: timeline
    type(step_end), allocatable :: ladder(:, :)     !! step operators for contact forces, by level, (0:levels, configurations)
    type(string), allocatable :: notes(:)
  end type beam_motion

end module bw_beam_motion
