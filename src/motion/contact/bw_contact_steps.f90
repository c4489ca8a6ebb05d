module bw_contact_steps
  !! The steps of one contact, from its start or a change of the beam to its end, the next change, or the end of the
  !! record. bw_lasting_contact explains their lengths. Units of bw_segment.
  use bw_contact_bodies, only: contact_bodies
  use bw_contact_force, only: end_in_step, find_largest, first_zero
  use bw_contact_law, only: contact_law, undamped_force, solve_contact
  use bw_double_double, only: dd, to_dd, operator(+)
  use bw_force_response, only: force_degree
  use bw_force_step, only: add_loads, force_in_step, find_force_step, force_step, last_coefficient, mean_force, node_places, &
    polynomial_of
  use bw_kinds, only: dp
  use bw_monitor, only: between_questions, monitor_type, stops
  use bw_segment, only: alone, load_type
  implicit none (type, external)
  private
  public :: step_through_contact

  integer, parameter, public :: most_halvings = 20       !! halvings from the longest step to the shortest

  type, public :: contact_run
    !! The current state of contacts and flights.
    integer :: configuration = alone              !! that moves
    type(contact_bodies) :: bodies
    type(contact_law) :: law
    type(force_step) :: ladder(0:most_halvings)          !! those in use have a length
    real(dp) :: unit = 0.0_dp                     !! the longest step
    real(dp) :: typical = 0.0_dp                  !! force scale of tolerances
    real(dp) :: tolerance = 0.0_dp
    real(dp) :: in_range = huge(1.0_dp)           !! until the motion overflows
    real(dp) :: last = 0.0_dp                     !! end of the search
    integer :: most_contacts = 1
    integer :: contacts = 0
    integer :: event = 0                          !! of the current contact
    integer :: steps = 0                          !! of its current segment
    logical :: found = .false.                    !! a contact starts or continues
    logical :: goes_on = .false.
    logical :: changed = .false.                  !! the beam has changed, and the force may jump
    logical :: cut = .false.
    real(dp) :: gained(3) = 0.0_dp                !! energy, momentum and hub rate added by changes during the contact
    real(dp) :: approach = 0.0_dp, rate_before = 0.0_dp   !! closing speed, and hub rate, at the start of the contact
    logical :: captures = .false., captured = .false.
    real(dp) :: last_indentation = 0.0_dp, last_force = 0.0_dp   !! at the end of the last step
    logical :: ended = .false., failed = .false.
    real(dp) :: impulse = 0.0_dp, deepest = 0.0_dp   !! of the current contact
    real(dp) :: indentation = 0.0_dp              !! largest of all contacts
    type(dd) :: end_time
    real(dp), allocatable :: error(:, :), beyond(:, :)   !! see segment_type, of the next segment; unallocated: none
  end type contact_run

contains

  subroutine step_through_contact(run, steps, monitor)
    !! Step through a contact to the end of its force, or to the end of the search.
    type(contact_run), intent(inout) :: run
    type(load_type), intent(inout) :: steps
    class(monitor_type), intent(inout), optional :: monitor
    type(force_step) :: odd
    real(dp), dimension(force_degree) :: indentation, rate
    real(dp) :: force(0:force_degree), closing(0:force_degree), lack, largest, left, until
    real(dp), allocatable :: load(:, :), slope(:, :), by_loads(:, :)   ! other loads; unallocated: none
    logical :: converged, ends, is_last
    integer :: level
    force = 0.0_dp
    if (run%bodies%held /= 0.0_dp) by_loads = spread([-run%bodies%held, 0.0_dp], 1, force_degree)
    if (allocated(run%bodies%loads)) then
      allocate (load(0:force_degree, size(run%bodies%loads%course)))
      slope = load
      by_loads = spread([0.0_dp, 0.0_dp], 1, force_degree)
    end if
    if (allocated(load) .or. run%changed .or. run%goes_on) &
      force(0) = force_after_jump(run, merge(run%last_force, 0.0_dp, run%goes_on))
    run%changed = .false.
    closing(0) = -run%bodies%separation()
    level = 0                                        ! a force starting with zero closing speed is smooth: t^3
    if (run%goes_on .or. closing(0)*run%unit*0.5_dp**most_halvings > run%bodies%rounding()) level = most_halvings
    largest = run%typical
    run%steps = 0
    run%ended = .false.
    run%failed = .false.
    allocate (steps%length(64), steps%level(64), steps%force(0:force_degree, 64))
    associate (state => run%bodies%state)
      do
        if (mod(run%steps, between_questions) == 0) then
          if (stops(monitor)) return
        end if
        until = run%last
        if (allocated(load)) until = min(until, run%bodies%loads%next(state%time%hi))
        left = (until - state%time%hi) - state%time%lo
        is_last = run%unit*0.5_dp**level >= left
        if (is_last) then
          call find_step(left, odd)
        else if (run%ladder(level)%length == 0.0_dp) then
          call find_step(run%unit*0.5_dp**level, run%ladder(level))
        end if
        if (allocated(load)) then
          call run%bodies%loads%in_step(state%time%hi, merge(left, run%unit*0.5_dp**level, is_last), load, slope, lack)
          if (level < most_halvings .and. lack > run%tolerance) then
            level = level + 1
            cycle
          end if
          if (is_last) then
            call find_load_approach(odd)
          else
            call find_load_approach(run%ladder(level))
          end if
        end if
        force(1:) = expected_force(merge(left, run%unit*0.5_dp**level, is_last))
        if (is_last) then
          call solve_contact(run%law, odd, state%u, state%v, force, indentation, rate, converged, by_loads)
        else
          call solve_contact(run%law, run%ladder(level), state%u, state%v, force, indentation, rate, converged, by_loads)
        end if
        lack = last_coefficient(force)
        largest = max(largest, maxval(force))
        ends = any(indentation <= 0.0_dp .or. force(1:) <= 0.0_dp)
        if (level < most_halvings .and. (ends .or. .not. converged .or. lack > run%tolerance*largest)) then
          level = level + 1
          cycle
        end if
        run%failed = .not. converged
        if (run%failed) return
        closing(1:) = rate
        if (run%captures .and. any(rate <= 0.0_dp)) then
          left = first_zero(closing)*merge(left, run%unit*0.5_dp**level, is_last)
          is_last = .true.
          call find_step(left, odd)
          if (allocated(load)) then
            call run%bodies%loads%in_step(state%time%hi, left, load, slope, lack)
            call find_load_approach(odd)
          end if
          call solve_contact(run%law, odd, state%u, state%v, force, indentation, rate, converged, by_loads)
          run%captured = .true.
          ends = .false.
        end if
        call append_step(run, steps, merge(left, run%unit*0.5_dp**level, is_last), level, force, indentation)
        if (ends) run%end_time = state%time + end_in_step(steps%length(run%steps), indentation, force)
        if (is_last) then
          call odd%advance(force, state%u, state%v)
          if (allocated(load)) call odd%push(run%bodies%loads%drive, load, state%u, state%v)
        else
          call run%ladder(level)%advance(force, state%u, state%v)
          if (allocated(load)) call run%ladder(level)%push(run%bodies%loads%drive, load, state%u, state%v)
        end if
        state%time = state%time + steps%length(run%steps)
        run%ended = ends .or. run%captured
        run%last_force = merge(0.0_dp, force(force_degree), ends)
        run%last_indentation = indentation(force_degree)
        if (run%ended .or. (is_last .and. .not. until < run%last)) exit
        force(0) = force(force_degree)
        if (is_last) then                            ! a load has a kink here
          state%time = to_dd(until)
          force(0) = force_after_jump(run, force(0))
        end if
        closing(0) = rate(force_degree)
        if (run%captures .and. is_last) then         ! omitted modes may jump with the rate of a load
          run%captured = run%bodies%separation() >= 0.0_dp
          run%ended = run%captured
          run%last_force = force(0)
          if (run%captured) exit
        end if
        if (lack < run%tolerance*largest*0.5_dp**(force_degree + 1)) level = max(0, level - 1)
      end do
      if (run%captured .or. .not. run%ended) run%end_time = state%time
    end associate
    steps%length = steps%length(:run%steps)
    steps%level = steps%level(:run%steps)
    steps%force = steps%force(:, :run%steps)
  contains
    pure function expected_force(length) result(expected)
      !! Return a first guess of the force: the last step, continued linearly.
      real(dp), intent(in) :: length
      real(dp) :: expected(force_degree), last, slope
      expected = 0.0_dp
      if (run%steps == 0 .and. run%goes_on) expected = force(0)
      if (run%steps == 0) return
      call force_in_step(polynomial_of(steps%force(:, run%steps)), 1.0_dp, last, slope)
      expected = last + slope*node_places(1:)*(length/steps%length(run%steps))
    end function expected_force

    subroutine find_load_approach(step)
      !! Find the contribution of loads and of the equilibrium deflection to the approach.
      type(force_step), intent(in) :: step
      by_loads(:, :) = run%bodies%loads%see(step, load, slope)
      by_loads(:, 1) = by_loads(:, 1) - run%bodies%held
    end subroutine find_load_approach

    subroutine find_step(length, step)
      real(dp), intent(in) :: length
      type(force_step), intent(out) :: step
      call find_force_step(run%bodies%parts, run%bodies%weight, run%bodies%inertia, length, step)
      if (allocated(run%bodies%loads)) call add_loads(run%bodies%parts, run%bodies%weight, run%bodies%loads%drive, step)
    end subroutine find_step
  end subroutine step_through_contact

  pure real(dp) function force_after_jump(run, before) result(force)
    !! Return the force where loads, and omitted modes with them, may have jumped. With damping it is kept, and short steps follow.
    type(contact_run), intent(in) :: run
    real(dp), intent(in) :: before
    force = before
    if (run%law%damping == 0.0_dp) force = undamped_force(run%law, -run%bodies%gap())
  end function force_after_jump

  pure subroutine append_step(run, load, length, level, force, indentation)
    !! Append a step to a load.
    type(contact_run), intent(inout) :: run
    type(load_type), intent(inout) :: load
    real(dp), intent(in) :: length, force(0:), indentation(:)
    integer, intent(in) :: level
    type(load_type) :: longer, depth
    real(dp) :: deepest, time
    if (run%steps == size(load%length)) then
      allocate (longer%length(2*run%steps), longer%level(2*run%steps), longer%force(0:force_degree, 2*run%steps))
      longer%length(:run%steps) = load%length
      longer%level(:run%steps) = load%level
      longer%force(:, :run%steps) = load%force
      call move_alloc(longer%length, load%length)
      call move_alloc(longer%level, load%level)
      call move_alloc(longer%force, load%force)
    end if
    run%steps = run%steps + 1
    load%length(run%steps) = length
    load%level(run%steps) = level
    load%force(:, run%steps) = force
    depth%force = reshape([run%last_indentation, indentation], [force_degree + 1, 1])
    if (maxval(depth%force) >= run%deepest) then
      deepest = indentation(force_degree)
      if (maxval(depth%force) > deepest) then         ! the peak is in this step
        depth%length = [length]
        call find_largest(depth, deepest, time)
      end if
      run%deepest = max(run%deepest, deepest)
    end if
    run%impulse = run%impulse + length*mean_force(force)
  end subroutine append_step

end module bw_contact_steps
