module bw_case_result
  !! The result of a case, and the values that its stages pass on.
  use bw_beam_motion, only: beam_motion
  use bw_beam_units, only: beam_units
  use bw_error, only: error_type
  use bw_event, only: event_type
  use bw_impact, only: impact_type
  use bw_kinds, only: dp
  use bw_measured, only: measured_type
  use bw_missing, only: missing
  use bw_mode_set, only: configuration_type, mode_set, search_failure
  use bw_plan, only: plan_type
  use bw_record, only: record_extent
  use bw_record_lines, only: record_lines
  use bw_response, only: response_type
  use bw_response_extremes, only: extreme_type
  use bw_scene, only: scene_type
  use bw_segment, only: segment_type
  use bw_text, only: append, string
  implicit none (type, external)
  private
  public :: add_notes, octave_of

  integer, parameter, public :: case_done = 0, case_diverged = 1, case_not_converged = 2, case_ill_conditioned = 3, &
    case_misfit = 4, case_no_free_decay = 5
  character(*), parameter, public :: case_words(0:5) = &
    [character(15) :: 'done', 'diverged', 'not_converged', 'ill_conditioned', 'misfit', 'no_free_decay']   !! by number

  type, extends(beam_motion), public :: case_motion
    !! What is known of a case before its histories are summed.
    type(plan_type) :: plan                         !! how many modes a tolerance sums in each segment
    integer :: ending = case_done                   !! status: why the motion is not known to its end
  end type case_motion

  type, public :: block_type
    !! The largest values of the last two octaves of a segment's modes at any sample, SI, (points, 2).
    real(dp), allocatable :: value(:, :)            !! displacements, or curvatures
    real(dp), allocatable :: rate(:, :)             !! velocities
  end type block_type

  type, public :: case_histories
    type(response_type), allocatable :: response    !! SI; unallocated if no history is requested
    type(block_type), allocatable :: blocks(:)      !! (segments)
    real(dp), allocatable :: octave_moment(:)       !! the largest moment of the last octave, N m, (points)
    integer :: status = case_done
    type(string), allocatable :: notes(:)
  end type case_histories

  type, public :: history_errors
    !! Estimates of the largest error of each history; unallocated if there is none.
    real(dp), allocatable :: displacement(:)        !! m, (points)
    real(dp), allocatable :: displacement_bound(:)  !! proved bound, m, (points)
    real(dp), allocatable :: velocity(:)            !! m/s, (points)
    real(dp), allocatable :: bending_moment(:)      !! N m, (points)
    real(dp), allocatable :: acceleration(:)        !! m/s², (points)
    real(dp), allocatable :: shear_force(:)         !! N, (points)
    real(dp), allocatable :: part(:, :)             !! |sum of a block| over the sum of its amplitudes, (points, segments)
    integer :: status = case_done                   !! of the case, with these errors
    type(string), allocatable :: notes(:)
    integer :: segment = 1                          !! with the largest error
    logical :: missed = .false.                     !! the estimate or the bound misses the tolerance
  end type history_errors

  type, public :: answer_type
    !! The frequency response of the points, SI units per N.
    complex(dp), allocatable :: value(:, :)         !! (frequencies, points)
    real(dp), allocatable :: error(:)               !! estimated largest error; unallocated if only rounding limits it, (points)
    real(dp), allocatable :: junction(:)            !! ξ of bodies and steps within a beam of uniform pieces; missing: none
    real(dp), allocatable :: transmitted(:, :), reflected(:, :) !! shares of a wave's power there, (frequencies, junctions)
    type(extreme_type), allocatable :: extremes(:)  !! resonances and antiresonances, SI; unallocated if not requested
  end type answer_type

  type, public :: case_spectrum
    real(dp), allocatable :: amplitude(:, :)        !! m, (frequencies, points)
    type(measured_type), allocatable :: measured    !! waves, SI
    type(string), allocatable :: notes(:)
  end type case_spectrum

  type, public :: record_result
    !! Results of a record besides frequencies and waves, SI.
    type(record_extent) :: extent
    type(record_lines) :: lines
    real(dp), allocatable :: recorded(:, :), fitted(:, :)   !! at the times of the plot, (times, sensors)
    real(dp), allocatable :: noise(:, :)                    !! rms amplitude spectrum of the noise, (frequencies, sensors)
    real(dp), allocatable :: constant_real(:, :), constant_imag(:, :), constant_error(:, :)
      !! modal constants of a hammer's impact, and half the interval of real and imaginary part, 1/kg, (lines, sensors);
      !! unallocated: no hammer
    real(dp), allocatable :: response_real(:, :), response_imag(:, :)   !! response of the sensors per N, (frequencies, sensors)
    real(dp), allocatable :: impulse(:, :)                  !! |F| of the force, N s, (frequencies, 1)
    real(dp) :: stiffness_root(2) = missing                 !! √(EI/ρA) from the dispersion relation, and half its interval, m²/s
    real(dp) :: angular_velocity(2) = missing               !! |ω| from it, and half its interval, rad/s
  end type record_result

  type, public :: contact_result
    !! Results of lasting contacts besides their events, SI.
    real(dp), allocatable :: force(:, :)            !! at Chebyshev points from start to end of each contact, N, (samples, events)
    real(dp), allocatable :: force_error(:)         !! estimate of its largest error; missing if there is none, N, (events)
    real(dp), allocatable :: largest(:)             !! N, (events)
    real(dp), allocatable :: largest_time(:)        !! s, (events)
    real(dp) :: restitution = missing               !! of the first contact, with or without a second
    real(dp) :: approach = 0.0_dp                   !! closing speed at the first contact, m/s
    real(dp) :: indentation = 0.0_dp                !! largest of all contacts, m
    real(dp) :: leaving = missing                   !! velocity of the mass after the last contact, m/s
    logical :: lasting = .false.                    !! the last contact outlasts the record
  end type contact_result

  type, public :: load_result
    !! The applied loads, in the order of the scene.
    integer :: count = 0                            !! modes summed under loads
    real(dp) :: until = 0.0_dp                      !! when the last load ends, s
    real(dp), allocatable :: applied_force(:)       !! largest magnitude of each force, N
    real(dp), allocatable :: applied_impulse(:)     !! its impulse, N s
    real(dp), allocatable :: applied_acceleration(:)   !! largest magnitude of each acceleration of the base, m/s²
    real(dp), allocatable :: applied_velocity(:)    !! velocity change of the base by each, m/s
    type(string), allocatable :: notes(:)
  end type load_result

  type, public :: simulation
    !! A case from its modes to its histories and their errors.
    type(scene_type) :: counted                     !! the scene with the numbers of modes that were summed
    type(case_motion), allocatable :: motion
    type(case_histories) :: histories
    type(history_errors) :: errors
    type(contact_result), allocatable :: contact    !! of lasting contacts
    type(load_result), allocatable :: loads
    type(search_failure) :: failure                 !! the first mode that was not found
  end type simulation

  type, public :: modal_model
    !! The modal model that a result exports to other programs, SI. Unallocated if there are no modes.
    real(dp), allocatable :: stiffness(:)           !! Mβ², N/m, (modes)
    real(dp), allocatable :: damping(:)             !! Mc, N s/m, (modes)
    real(dp), allocatable :: participation(:)       !! ∫ρAΦ dx with the part of bodies, kg, (modes)
    real(dp), allocatable :: turn_participation(:)  !! ∫ρAxΦ dx with the part of rotary inertia and bodies, kg m, (modes)
    real(dp), allocatable :: shape(:, :)            !! Φ, (points, modes)
    real(dp), allocatable :: slope(:, :)            !! Φ', or with shear the rotation of the section, 1/m, (points, modes)
    real(dp), allocatable :: moment(:, :)           !! EIΦ'', N, (points, modes)
    real(dp), allocatable :: shear(:, :)            !! N/m, (points, modes)
    real(dp), allocatable :: residual(:, :, :)
      !! static contribution of all other modes to deflection, moment and shear force per N, (forces, points, 3)
    real(dp), allocatable :: base_residual(:, :)    !! the same per m/s² of base acceleration, (points, 3)
    real(dp), allocatable :: hub_turn(:)            !! rotation of a free hub, 1/m, (modes)
    real(dp), allocatable :: hub_residual(:)        !! static contribution of all other modes to it per N, rad/N, (forces)
    real(dp) :: base_hub_residual = missing         !! the same per m/s² of base acceleration, s²/m
    real(dp) :: mass = missing                      !! all that moves, kg
    real(dp), allocatable :: initial_displacement(:)   !! q after the last event at t = 0, m, (modes)
    real(dp), allocatable :: initial_velocity(:)    !! q̇ after it, m/s, (modes)
  end type modal_model

  type, public :: case_result
    !! The result of a case. A component that was not requested is unallocated.
    type(beam_units) :: units
    class(mode_set), allocatable :: modes             !! after t = 0, or the first of them
    integer :: mode_count = 0                         !! modes summed
    real(dp) :: reached = 0.0_dp                      !! with a tolerance: estimated displacement error over its peak
    logical :: within = .true.                        !! `reached` meets the tolerance
    integer :: profile_points = 0                     !! points of mode shapes and velocity jump along the beam; 0: neither
    class(mode_set), allocatable :: before            !! modes of the beam alone, if the mass was captured
    type(configuration_type), allocatable :: configurations(:)   !! all of a beam that changes in time
    logical :: can_grow = .false.                     !! a mode may be unstable at some angular velocity
    type(impact_type), allocatable :: impact
    real(dp) :: approach_velocity = 0.0_dp            !! V, m/s
    real(dp) :: lever = 0.0_dp                        !! distance of the struck place from the axis of a free hub, m
    real(dp), allocatable :: modal_displacement(:)    !! at t = 0, in V times the unit of time; unallocated: 0, (modes)
    real(dp), allocatable :: modal_velocity(:)        !! after the last event at t = 0, in V, (modes)
    real(dp), allocatable :: velocity_jump(:)         !! Σφ_iΔq̇_i along the beam, in V, (profile)
    type(event_type), allocatable :: events(:)        !! in order of time
    type(segment_type), allocatable :: segments(:)    !! in order of time
    type(response_type), allocatable :: response      !! SI
    real(dp), allocatable :: amplitude(:, :)          !! m, (frequencies, points)
    type(answer_type), allocatable :: answer          !! to a harmonic force
    type(measured_type), allocatable :: measured      !! SI
    type(contact_result), allocatable :: contact      !! of lasting contacts
    type(load_result), allocatable :: loads           !! of forces and motions of the base
    type(record_result), allocatable :: record        !! of a record
    type(modal_model), allocatable :: model
    integer :: status = case_done
    type(string), allocatable :: notes(:)             !! warnings and remarks (bw_note)
    type(error_type), allocatable :: error            !! why there is no result: the record cannot be read
  end type case_result

contains

  pure function octave_of(histories, points, rates) result(largest)
    !! Return the largest displacement, or velocity, that the last octave of modes contributes in any segment, (points).
    type(case_histories), intent(in) :: histories      !! summed
    integer, intent(in) :: points
    logical, intent(in), optional :: rates
    real(dp) :: largest(points)
    logical :: of_rates
    integer :: i
    of_rates = .false.
    if (present(rates)) of_rates = rates
    largest = 0.0_dp
    do i = 1, size(histories%blocks)
      associate (block => histories%blocks(i))
        if (.not. allocated(block%value)) cycle
        if (of_rates) then
          largest = max(largest, block%rate(:, 2))
        else
          largest = max(largest, block%value(:, 2))
        end if
      end associate
    end do
  end function octave_of

  pure subroutine add_notes(notes, more)
    !! Append the notes of a stage.
    type(string), allocatable, intent(inout) :: notes(:)
    type(string), intent(in), optional :: more(:)    !! absent: none
    integer :: i
    if (.not. present(more)) return
    do i = 1, size(more)
      call append(notes, more(i)%text)
    end do
  end subroutine add_notes

end module bw_case_result
