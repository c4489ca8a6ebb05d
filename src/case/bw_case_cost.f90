module bw_case_cost
  !! The cost of a case: seconds of its stages, each a sum of counts known before the run times the seconds of one, and
  !! bytes of its modes. It divides the progress bar and gives the numbers of `check`. Seconds are those of one core,
  !! within a factor of 3.
  use bw_beam_units, only: slenderness, units_of
  use bw_case_frequency, only: modes_of_answer
  use bw_case_modes, only: first_modes, most_in_run, most_to_tolerance
  use bw_input_values, only: position_of
  use bw_constants, only: pi
  use bw_kinds, only: dp, i8
  use bw_load_course, only: course_of_shape, lag_bound
  use bw_load_par, only: load_par
  use bw_missing, only: is_missing
  use bw_modes_par, only: by_tolerance
  use bw_monitor, only: monitor_type, part_monitor
  use bw_scene, only: answers_by_modes, by_pieces, changes_in_time, changes_shapes, converges_in_run, has_configurations, &
    is_let_go, is_loaded, is_planned, scene_type
  use bw_sum_choice, only: product_seconds, sum_seconds
  use bw_timeline, only: is_released, most_configurations, most_events
  implicit none (type, external)
  private
  public :: case_bytes, case_counts, case_shares, modes_seconds, seconds_of, shared_terms, stage_part

  integer, parameter, public :: modes_share = 1, events_share = 2, later_share = 3, histories_share = 4, spectrum_share = 5, &
    answer_share = 6
    !! `events_share`: events at t = 0; `later_share`: later ones
  integer, parameter :: shares = 6, whole_run = 7

  type :: term_type
    integer :: stage = 0
    real(dp) :: seconds = 0.0_dp                     !! of one count
  end type term_type

  enum, bind(c)                                      ! terms, in the order of the table
    enumerator :: closed_modes = 1, piece_modes, unknowns_cubed, unknowns_squared, closed_places, other_places, capture_pairs
    enumerator :: plans, closed_releases, other_releases, contacts, loaded_steps, plain_sums, damped_sums, error_estimates
    enumerator :: search_transforms
    enumerator :: line_searches, line_samples, answers, modal_answers, numbers_term, cases_term, run_term
  end enum
  public :: numbers_term, cases_term, run_term

  ! Fitted: bench/cost prints these lines.
  type(term_type), parameter :: term(*) = [ &
    term_type(modes_share, 3.6e-8_dp), &             !! a mode in closed form
    term_type(modes_share, 1.2e-5_dp), &             !! a mode in a piece
    term_type(modes_share, 2.7e-10_dp), &            !! the cube of the unknowns of Galerkin's method
    term_type(modes_share, 2.2e-7_dp), &             !! their square
    term_type(events_share, 3.7e-8_dp), &            !! a mode in closed form at a place of the profile
    term_type(events_share, 3.7e-8_dp), &            !! any other mode there
    term_type(events_share, 4.0e-9_dp), &            !! a pair of modes before and after a capture that have no closed form
    term_type(events_share, 1.9e-4_dp), &            !! a plan by tolerance
    term_type(later_share, 3.6e-8_dp), &             !! a pair before and after a release in closed form
    term_type(later_share, 6.1e-6_dp), &             !! such a pair without closed form where a tolerance is planned
    term_type(later_share, 1.4e-5_dp), &             !! a mode in a contact of any kind
    term_type(histories_share, 1.5e-9_dp), &         !! a sample of a mode under loads, and of each of its histories
    term_type(histories_share, 1.8_dp), &            !! a second of the cost model of bw_sum_choice
    term_type(histories_share, 4.6_dp), &            !! the same for damped modes
    term_type(histories_share, 1.0e-7_dp), &         !! a mode at a point, where its error is estimated
    term_type(spectrum_share, 2.8e-8_dp), &          !! a sample and octave of the transforms that a search takes
    term_type(spectrum_share, 0.12_dp), &            !! a search for lines
    term_type(spectrum_share, 2.3e-8_dp), &          !! a line in a sample
    term_type(answer_share, 1.6e-6_dp), &            !! a piece and point at a frequency of a harmonic force
    term_type(answer_share, 1.0e-8_dp), &            !! a mode and point there
    term_type(whole_run, 5.2e-8_dp), &               !! a number of the result
    term_type(whole_run, 6.0e-5_dp), &               !! a case
    term_type(whole_run, 1.6e-2_dp)]                 !! the program and its files
  integer, parameter, public :: term_count = size(term)
  real(dp), parameter :: times_over = 2.0_dp         !! cost of all mode counts that a tolerance tries, over that of the last
  integer, parameter :: most_loaded = 1024           !! modes that the default tolerance may sum if accelerations are requested
  real(dp), parameter :: gauss_stages = 8.0_dp       !! quadrature points in a half wave
  real(dp), parameter :: changing_passes = 80.0_dp !! over pairs of modes before and after a change, partly integrated: seven runs
  real(dp), parameter :: loaded_passes = 4.0_dp*changing_passes/7.0_dp !! of one run under loads, which projects 4 times as many
  real(dp), parameter :: changing_sums = 4.4_dp      !! modes summed in all runs over those of the full run
  real(dp), parameter :: contact_modes = 256.0_dp    !! summed by the default tolerance in a lasting impact
  real(dp), parameter :: cautious = 5.0_dp           !! an estimate over the error, in the median
  real(dp), parameter :: contact_pass = 8.0_dp       !! over the modes of a motion in two runs of a lasting contact
  real(dp), parameter :: beside = 5.0_dp             !! time of contacts on a beam that changes or is loaded, over that of others
  real(dp), parameter :: usual_contacts = 8.0_dp     !! of a long record

contains

  pure function case_shares(scene) result(part)
    !! Return the share of each stage in the time of a case; they add to 1.
    type(scene_type), intent(in) :: scene          !! without sweeps
    real(dp) :: part(shares)
    real(dp) :: seconds(term_count)
    integer :: s
    seconds = term%seconds*case_counts(scene, first_modes)
    part = [(sum(seconds, term%stage == s), s=1, shares)]
    part = part/sum(part)
  end function case_shares

  pure real(dp) function modes_seconds(scene) result(seconds)
    !! Return the time to find the modes of a case, s.
    type(scene_type), intent(in) :: scene          !! without sweeps, whose modes are counted
    seconds = sum(term%seconds*case_counts(scene, scene%modes%before), term%stage == modes_share)
  end function modes_seconds

  pure real(dp) function seconds_of(counts) result(seconds)
    !! Return the time of all terms, s.
    real(dp), intent(in) :: counts(:)              !! how often each term occurs
    seconds = sum(term%seconds*counts)
  end function seconds_of

  pure function case_counts(scene, planned) result(counts)
    !! Count how often each term occurs in a case.
    type(scene_type), intent(in) :: scene          !! without sweeps
    integer, intent(in) :: planned                 !! modes that a tolerance sums
    real(dp) :: counts(term_count)
    real(dp) :: before, after, moving, pieces, found, followed
    logical :: closed, driven, planning
    planning = by_tolerance(scene%modes)
    closed = .not. changes_shapes(scene)
    pieces = pieces_of_scene(scene)
    before = merge(0, scene%modes%before, planning)
    after = merge(merge(planned, scene%modes%after, planning), 0, allocated(scene%capture))
    moving = merge(after, before, allocated(scene%capture))
    if (converges_in_run(scene) .and. planning) then     ! the run itself finds the count of its tolerance
      moving = first_modes*2
      if (allocated(scene%contact)) then
        moving = modes_of_contact(scene)
      else if (is_loaded(scene) .and. .not. changes_in_time(scene)) then
        moving = 2.0_dp*modes_under_loads(scene)
      end if
      before = moving
    end if
    found = before + after
    if (has_configurations(scene)) then
      after = merge(moving, real(scene%modes%after, dp), planning)
      moving = max(before, after)
      found = before + (most_configurations(scene) - 1)*after
    end if
    ! with shear most plans are made twice
    if (is_planned(scene)) found = first_modes + merge(6.0_dp, 3.0_dp, allocated(scene%shear))*planned
    counts = 0.0_dp
    if (closed) then
      counts(closed_modes) = found
    else if (by_pieces(scene)) then
      counts(piece_modes) = found*pieces
    else
      counts([unknowns_cubed, unknowns_squared]) = galerkin_counts(scene, before, after, planning)
    end if
    if (allocated(scene%impact) .and. .not. planning) &
      & counts(merge(closed_places, other_places, closed)) = before*scene%impact%profile_points
    if (allocated(scene%capture) .and. .not. (planning .or. closed)) &
      & counts(capture_pairs) = merge(2, 1, is_released(scene))*before*after
    if (is_planned(scene)) counts(plans) = 1.0_dp
    if (allocated(scene%contact)) counts(contacts) = contact_pass*number_of_contacts(scene)*before &
      & *merge(beside, 1.0_dp, is_loaded(scene) .or. changes_in_time(scene))
    if (has_configurations(scene)) counts(capture_pairs) = changing_passes*most_events(scene, 0)*moving**2
    if (is_released(scene) .and. (planning .or. closed)) &
      & counts(merge(closed_releases, other_releases, closed)) = max(moving, before)*moving
    if (allocated(scene%recontact)) counts(contacts) = scene%recontact%max_contacts*before
    if (allocated(scene%frequency_response)) then
      associate (asked => scene%frequency_response)
        counts(answers) = size(asked%frequency)*(pieces + size(asked%points))
        if (answers_by_modes(scene)) counts(modal_answers) = 2.0_dp*size(asked%frequency)*size(asked%points)*modes_of_answer
      end associate
    end if
    if (scene%modes%modal_model) call add_integrals(moving)
    if (.not. allocated(scene%response)) return
    associate (response => scene%response, points => size(scene%response%points))
      counts(merge(damped_sums, plain_sums, allocated(scene%damping))) = seconds_of_sums(scene, moving)
      if (changes_in_time(scene) .and. .not. is_let_go(scene)) &
        & counts([damped_sums, plain_sums]) = changing_sums*counts([damped_sums, plain_sums])
      counts(error_estimates) = moving*points
      driven = is_loaded(scene)
      if (allocated(scene%contact)) driven = driven .or. response%acceleration .or. response%shear_force
      if (driven) then
        followed = 2.0_dp*moving                      ! twice the modes, for the error estimate
        if (planning .and. .not. allocated(scene%contact)) followed = 2.0_dp*modes_under_loads(scene)
        if (changes_in_time(scene)) counts(capture_pairs) = counts(capture_pairs) &
          + loaded_passes*(most_events(scene, 0) - count([allocated(scene%impact), allocated(scene%capture)]))*followed**2
        if (planning) followed = times_over*followed
        counts(loaded_steps) = followed*response%samples*(4.0_dp + points*count([.true., response%velocity, response%acceleration, &
                                                                               response%bending_moment, response%shear_force]))
        if (response%shear_force .or. allocated(scene%bases)) call add_integrals(followed)
      end if
      if (.not. allocated(scene%spectrum)) return
      if (.not. (any(response%points == 0.5_dp) .and. any(response%points == 1.0_dp))) return   ! waves are measured there
      counts(search_transforms) = response%samples*(log(real(response%samples, dp))/log(2.0_dp))*points
      counts(line_searches) = 1.0_dp
      counts(line_samples) = response%samples*min(moving, 200.0_dp)
    end associate
  contains
    pure subroutine add_integrals(modes)
      !! Add the integrals of mass times shape, over the half waves of the last mode.
      real(dp), intent(in) :: modes
      associate (places => counts(merge(closed_places, other_places, closed)))
        places = places + gauss_stages*modes**2
      end associate
    end subroutine add_integrals
  end function case_counts

  pure real(dp) function modes_of_contact(scene) result(modes)
    !! Return how many modes a tolerance sums in a lasting impact: errors fall as n^-3, those of accelerations as n^-1.5.
    type(scene_type), intent(in) :: scene
    real(dp), parameter :: most = 4096.0_dp
    associate (tolerance => scene%modes%tolerance)
      modes = contact_modes*(1.0e-6_dp/tolerance)**(1.0_dp/3.0_dp)
      if (scene%response%acceleration) &
        modes = most_loaded*merge((1.0e-4_dp/tolerance)**(2.0_dp/3.0_dp), 1.0_dp, scene%modes%asked)
      modes = min(most, modes)
    end associate
  end function modes_of_contact

  pure real(dp) function number_of_contacts(scene) result(number)
    !! Estimate the number of lasting contacts: no more than the record has room for, each as long as one with a wall, about 3d/V
    !! with the largest indentation d.
    type(scene_type), intent(in) :: scene
    real(dp) :: depth, speed
    associate (contact => scene%contact, units => units_of(scene%beam))
      number = min(usual_contacts, real(contact%max_contacts, dp))
      speed = abs(scene%impact%approach_velocity)
      if (speed == 0.0_dp) return
      depth = ((contact%exponent + 1.0_dp)/2.0_dp*scene%impact%mass_ratio*units%mass*speed**2/contact%stiffness) &
        **(1.0_dp/(contact%exponent + 1.0_dp))
      number = min(number, 1.0_dp + scene%response%duration/max(3.0_dp*depth/speed, tiny(depth)))
    end associate
  end function number_of_contacts

  pure real(dp) function modes_under_loads(scene) result(modes)
    !! Return how many modes a tolerance sums under loads: until the part of the last, by how much it lags behind the loads and as far
    !! as the requested quantities show it, is within the tolerance.
    type(scene_type), intent(in) :: scene
    real(dp) :: part
    integer :: l
    associate (most => most_in_run(scene, merge(4, 1, scene%modes%asked)*most_loaded), response => scene%response)
      modes = first_modes
      if (changes_in_time(scene) .and. (response%velocity .or. response%bending_moment)) modes = most
      do while (modes < most)
        part = 0.0_dp
        if (allocated(scene%forces)) part = maxval([(part_of(scene%forces(l)%load_par), l=1, size(scene%forces))])
        if (allocated(scene%bases)) part = max(part, maxval([(part_of(scene%bases(l))/modes, l=1, size(scene%bases))]))
        if (cautious*part <= scene%modes%tolerance) exit
        modes = min(real(most, dp), 2.0_dp*modes)
      end do
    end associate
  contains
    pure real(dp) function part_of(load) result(part)
      !! Return the part of the last mode over that of the first.
      type(load_par), intent(in) :: load
      real(dp) :: duration, frequency
      character(:), allocatable :: shape
      duration = scene%response%duration - load%start
      if (.not. is_missing(load%duration)) duration = load%duration
      shape = load%shape
      if (shape == 'file') shape = 'triangle'      ! linear between its samples, which are read later
      frequency = modes**2                         ! over that of the first
      if (allocated(scene%shear)) frequency = frequency/hypot(1.0_dp, 2.0_dp*pi*modes*slenderness(scene%beam))
      associate (units => units_of(scene%beam), response => scene%response)
        associate (unit => units%time%hi)
          part = lag_bound(course_of_shape(shape, 1.0_dp, load%start/unit, duration/unit, load%frequency*unit), &
                           response%duration/unit, 1.0_dp/(pi**2*frequency), 0.0_dp)
        end associate
        part = part*maxval(frequency**[-2, -1, 0, -2, -2]*modes**[0, 0, 0, 2, 3], &
          mask=[.true., response%velocity, response%acceleration, response%bending_moment, response%shear_force])
      end associate
    end function part_of
  end function modes_under_loads

  pure function shared_terms(scene) result(shared)
    !! Return which terms a case takes over from the case before: modes in closed form, unless the impact changes.
    type(scene_type), intent(in) :: scene          !! of this case, changed from that of the case before (bw_scene_cases)
    logical :: shared(term_count)
    integer :: impact
    shared = .false.
    impact = position_of(scene%groups, 'impact')
    if (changes_shapes(scene) .or. impact == 0) return
    shared([closed_modes, closed_places]) = .not. scene%groups(impact)%changed
  end function shared_terms

  pure real(dp) function seconds_of_sums(scene, modes) result(seconds)
    !! Return the time of the sums by the model of bw_sum_choice, s: histories, and moments at as many points.
    type(scene_type), intent(in) :: scene
    real(dp), intent(in) :: modes
    integer :: histories
    associate (response => scene%response)
      histories = size(response%points)
      seconds = seconds_of(merge(2*histories, histories, response%velocity))
      if (response%bending_moment) seconds = seconds + seconds_of(histories)
    end associate
  contains
    pure real(dp) function seconds_of(histories)
      integer, intent(in) :: histories
      if (allocated(scene%damping)) then           ! the transform sums no damped modes
        seconds_of = product_seconds(int(modes), scene%response%samples, histories)
      else
        seconds_of = sum_seconds(int(modes), scene%response%samples, histories)
      end if
    end function seconds_of
  end function seconds_of_sums

  pure function galerkin_counts(scene, before, after, planning) result(counts)
    !! Count cubes and squares of the unknowns of all mode sets. A tolerance doubles the modes until they suffice.
    type(scene_type), intent(in) :: scene
    real(dp), intent(in) :: before, after
    logical, intent(in) :: planning
    real(dp) :: counts(2)
    real(dp) :: count
    counts = 0.0_dp
    if (before > 0.0_dp) call add(merge(max(before, real(first_modes, dp)), before, is_released(scene)))
    if (planning .and. is_released(scene)) call add(real(first_modes, dp))
    if (after == 0.0_dp) return
    count = after
    if (allocated(scene%response)) count = merge(real(first_modes, dp), max(after, real(first_modes, dp)), planning)
    call add(count)
    do while (planning .and. count < after)
      count = 2.0_dp*count
      call add(count)
    end do
  contains
    pure subroutine add(modes)
      real(dp), intent(in) :: modes
      associate (u => unknowns(scene, modes))
        counts = counts + [u**3, u**2]
      end associate
    end subroutine add
  end function galerkin_counts

  pure real(dp) function pieces_of_scene(scene) result(pieces)
    !! Count the pieces. A body ends a piece.
    type(scene_type), intent(in) :: scene
    pieces = 1.0_dp
    if (allocated(scene%beam%pieces)) pieces = size(scene%beam%pieces)
    if (allocated(scene%bodies)) pieces = pieces + size(scene%bodies)
  end function pieces_of_scene

  pure real(dp) function unknowns(scene, count)
    !! Estimate the number of unknowns of Galerkin's method for so many modes.
    type(scene_type), intent(in) :: scene
    real(dp), intent(in) :: count
    real(dp), parameter :: many = 8.0_dp ! half waves in a piece: then, or with a tolerance, the first guess may fail
    real(dp) :: pieces
    pieces = pieces_of_scene(scene)
    unknowns = 10.0_dp + pieces*(16.0_dp + 6.0_dp*min(1.0_dp, count/pieces)) + 1.75_dp*count
    if (by_tolerance(scene%modes)) then
      unknowns = 1.25_dp*unknowns
    else if (pieces > 1.0_dp .and. count > many*pieces) then
      unknowns = 1.5_dp*unknowns
    end if
    if (allocated(scene%shear)) unknowns = 2.0_dp*unknowns
  end function unknowns

  pure real(dp) function most_modes(scene) result(most)
    !! Return how many modes under tension are found at once: those summed, or what estimates or a tolerance may need.
    type(scene_type), intent(in) :: scene
    most = max(scene%modes%before, scene%modes%after, merge(first_modes, 0, allocated(scene%response)))
    if (by_tolerance(scene%modes)) most = most_to_tolerance(merge(2, 1, allocated(scene%shear)))
  end function most_modes

  pure integer(i8) function case_bytes(scene) result(bytes)
    !! Return the peak memory of the modes of a case: measured, all but what its results take.
    type(scene_type), intent(in) :: scene          !! without sweeps
    integer, parameter :: of_mode = 18, of_piece = 6, of_pair = 3, of_matrix = 7, of_vector = 10, of_search = 1500   ! numbers
    real(dp) :: numbers, before, after
    before = scene%modes%before
    after = scene%modes%after
    if (.not. allocated(scene%capture)) after = 0.0_dp
    numbers = of_mode*(before + after)
    if (by_pieces(scene)) then
      numbers = numbers + (of_search + of_piece*(before + after))*pieces_of_scene(scene)
    else if (changes_shapes(scene)) then
      associate (count => most_modes(scene))
        numbers = numbers + of_matrix*unknowns(scene, count)**2 + of_vector*unknowns(scene, count)*count
      end associate
    end if
    if (allocated(scene%recontact)) numbers = numbers + of_pair*before**2
    bytes = 8*int(numbers, i8)
  end function case_bytes

  type(part_monitor) function stage_part(monitor, part, stage) result(stage_monitor)
    !! Begin a stage of a case, and return its monitor.
    class(monitor_type), intent(inout), target :: monitor
    real(dp), intent(in) :: part(:)                !! of `case_shares`
    integer, intent(in) :: stage
    character(*), parameter :: names(shares) = [character(8) :: 'modes', 'events', 'events', 'response', 'spectrum', 'response']
    call monitor%enter(trim(names(stage)))
    stage_monitor = part_monitor(monitor, sum(part(:stage - 1)), part(stage))
  end function stage_part

end module bw_case_cost
