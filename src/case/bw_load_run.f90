module bw_load_run
  !! The motion of a beam under its loads, with some modes: through the changes of its topology, to histories and what they lack of
  !! infinitely many modes.
  use bw_beam_units, only: beam_units
  use bw_case_result, only: case_modes
  use bw_double_double, only: dd, to_dd, operator(-)
  use bw_kinds, only: dp
  use bw_load_columns, only: factor_of_quantity, find_drive, list_columns, make_view, placed_loads, quantities
  use bw_load_course, only: interval_at, lag_bound, load_course, rates_of
  use bw_load_sum, only: load_tail, load_view, rounding_of, sum_loaded_modes, tail_error
  use bw_mode_set, only: configuration_type, first_numbers, mode_set
  use bw_monitor, only: monitor_type
  use bw_scene, only: scene_type
  use bw_scene_pieces, only: pieces_of, varying_of
  use bw_segment, only: alone, growth_ends
  use bw_time_grid, only: first_sample, time_grid, time_grid_of
  use bw_timeline, only: change_type, changes_of, happens
  use bw_varying_beam, only: varying_beam
  implicit none (type, external)
  private
  public :: follow_loads, largest_of

  type, public :: loaded_run
    !! The histories of some modes, SI.
    real(dp), allocatable :: history(:, :)         !! (samples, columns)
    real(dp), allocatable :: error(:)              !! (columns)
    real(dp), allocatable :: bound(:)              !! of the displacements, (points)
    integer, allocatable :: quantity(:), point(:)  !! (columns)
    integer :: samples = 0                         !! that are known
    integer :: count = 0                           !! modes
  end type loaded_run

contains

  subroutine follow_loads(scene, units, modes, summed, loads, monitor, run)
    !! The histories of the modes that are counted.
    type(scene_type), intent(in) :: scene
    type(beam_units), intent(in) :: units
    type(case_modes), intent(in) :: modes            !! with more than are summed, if there are
    integer, intent(in) :: summed(2)                 !! modes of each configuration that are
    type(placed_loads), intent(in) :: loads
    class(monitor_type), intent(inout) :: monitor
    type(loaded_run), intent(out) :: run
    type(load_view) :: view
    type(load_tail) :: tail
    type(time_grid) :: grid
    type(change_type), allocatable :: changes(:)
    real(dp), allocatable :: q(:), v(:), flexibility(:)
    real(dp) :: ends, factor, metre
    type(dd) :: start, until
    integer :: c, configuration, i, samples(2)
    associate (response => scene%response)
      call list_columns(response, [.true., response%velocity, response%acceleration, response%bending_moment, &
                                   response%shear_force], run%quantity, run%point)
    end associate
    grid = time_grid_of(scene%response%duration, scene%response%samples, units%time)
    allocate (run%history(grid%samples, size(run%quantity)), source=0.0_dp)
    allocate (run%error(size(run%quantity)), run%bound(size(scene%response%points)), source=0.0_dp)
    changes = changes_of(scene, units)
    configuration = modes%moving
    run%count = summed(configuration)
    run%samples = grid%samples
    start = to_dd(0.0_dp)
    do i = 0, size(changes)
      associate (set => modes%configuration(configuration)%set)
        ends = start%hi + growth_ends(set)
        until = to_dd(scene%response%duration/units%time%hi)
        if (i < size(changes)) then
          if (happens(changes(i + 1), scene, changes(i + 1)%time - start, set)) until = changes(i + 1)%time
        end if
        samples = [first_sample(start, grid), first_sample(until, grid) - 1]
        if (ends < until%hi) then
          samples(2) = min(samples(2), first_sample(to_dd(ends), grid) - 1)
          run%samples = samples(2)
          until = to_dd(ends)
        end if
        call make_view(beam_of(scene, units, configuration), set, summed(configuration), loads, scene%response%points, &
                       run%quantity, run%point, monitor, view, flexibility)
        if (monitor%stop_requested()) return
        if (.not. allocated(q)) q = spread(0.0_dp, 1, set%count)
        if (.not. allocated(v)) v = q
        if (allocated(tail%amplitude)) deallocate (tail%amplitude, tail%lag, tail%load, tail%largest, tail%squares)
        call sum_loaded_modes(set, view, grid, samples, start, until, monitor, q, v, run%history, tail)
        if (monitor%stop_requested()) return
        call add_errors()
        if (run%samples < grid%samples .or. until%hi >= scene%response%duration/units%time%hi) exit
        call hand_over(beam_of(scene, units, configuration), modes%configuration(configuration), &
                       modes%configuration(changes(i + 1)%configuration)%set, loads, until, monitor, q, v)
        if (monitor%stop_requested()) return
        configuration = changes(i + 1)%configuration
        start = until
      end associate
    end do
    metre = units%time%hi**2/units%mass                ! of displacements under loads in N
    do c = 1, size(run%quantity)
      factor = metre*factor_of_quantity(scene, units, run%quantity(c))
      run%history(:, c) = factor*run%history(:, c)
      run%error(c) = factor*run%error(c)
    end do
    run%bound = metre*run%bound
  contains
    subroutine add_errors()
      !! What is missing of infinitely many modes, the most of all segments, and rounding.
      real(dp) :: bound(size(run%bound)), missed(size(run%error)), rounding(size(run%error))
      integer, allocatable :: columns(:)
      integer :: o
      if (samples(2) < samples(1)) return
      do o = 1, quantities
        columns = pack([(c, c=1, size(run%quantity))], run%quantity == o)
        if (size(columns) == 0) cycle
        missed(columns) = tail_error(view, tail, columns)
      end do
      associate (set => modes%configuration(configuration)%set)
        bound = bound_of(set, view, flexibility, loads%course, until%hi)
        missed(:size(bound)) = min(missed(:size(bound)), bound)
        rounding = rounding_of(set, view, tail, until%hi)
        run%bound = max(run%bound, bound) + rounding(:size(bound))
        run%error = max(run%error, missed) + rounding
      end associate
    end subroutine add_errors
  end subroutine follow_loads

  pure function bound_of(modes, view, flexibility, courses, until) result(bound)
    !! A bound of what the displacements of infinitely many modes differ by: how much the missing ones lag behind each load, times their
    !! flexibility between its place and the point, by Cauchy and Schwarz. (points)
    class(mode_set), intent(in) :: modes
    type(load_view), intent(in) :: view
    real(dp), intent(in) :: flexibility(:)         !! as that of `make_view`
    type(load_course), intent(in) :: courses(:)
    real(dp), intent(in) :: until                  !! the end of the segment, l²/h
    real(dp) :: bound(size(flexibility) - size(courses))
    real(dp) :: drift, lag, square
    integer :: l
    square = modes%beta_squared(view%summed)%hi
    bound = huge(lag)
    if (square <= 1.0_dp) return
    drift = 0.0_dp
    if (allocated(modes%damping)) drift = max(modes%damping(view%summed)/square, modes%law%stiffness)
    lag = 1.0_dp/sqrt(square) + drift
    bound = 0.0_dp
    do l = 1, size(courses)
      bound = bound + sqrt(flexibility(:size(bound))*flexibility(size(bound) + l))*lag_bound(courses(l), until, lag, drift)
    end do
  end function bound_of

  pure type(varying_beam) function beam_of(scene, units, configuration) result(given)
    !! What the modes of a configuration are of.
    type(scene_type), intent(in) :: scene
    type(beam_units), intent(in) :: units
    integer, intent(in) :: configuration
    given = varying_of(scene, units, pieces_of(scene, units, configuration /= alone))
  end function beam_of

  subroutine hand_over(given, configuration, after, loads, time, monitor, q, v)
    !! The motion goes over to other modes, with that of modes that were not summed, which follow the loads at once.
    type(varying_beam), intent(in) :: given          !! before the change
    type(configuration_type), intent(in) :: configuration
    class(mode_set), intent(in) :: after
    type(placed_loads), intent(in) :: loads
    type(dd), intent(in) :: time
    class(monitor_type), intent(inout) :: monitor
    real(dp), allocatable, intent(inout) :: q(:), v(:)
    integer, parameter :: times_as_many = 4          ! modes are handed on as are summed
    class(mode_set), allocatable :: before
    real(dp), allocatable :: drive(:, :), moved(:), moving(:)
    real(dp) :: power(0:1)
    complex(dp) :: tone
    real(dp) :: no_points(0)
    real(dp), allocatable :: nothing(:, :)
    integer :: l, n
    n = configuration%set%count
    call configuration%source%find(first_numbers(min(configuration%source%highest, times_as_many*n)), before, monitor=monitor)
    if (monitor%stop_requested()) return
    allocate (nothing(before%count, 0))
    call find_drive(given, before, loads%place, loads%accelerated, monitor, drive, no_points, nothing)
    if (monitor%stop_requested()) return
    moved = spread(0.0_dp, 1, before%count)
    moving = moved
    do l = 1, size(loads%course)
      call rates_of(loads%course(l), interval_at(loads%course(l), time%hi), time%hi, power, tone)
      associate (soft => drive(:, loads%kind(l))/(before%modal_mass*before%beta_squared%hi))
        moved = moved + soft*(power(0) + real(tone))
        moving = moving + soft*(power(1) - loads%course(l)%frequency*aimag(tone))
      end associate
    end do
    moved(:n) = q
    moving(:n) = v
    q = after%overlap_of_beam(before, moved, monitor)/after%modal_mass
    v = after%overlap_of_beam(before, moving, monitor)/after%modal_mass
  end subroutine hand_over

  pure real(dp) function largest_of(run, quantity) result(peak)
    type(loaded_run), intent(in) :: run
    integer, intent(in) :: quantity
    integer :: c
    peak = 0.0_dp
    do c = 1, size(run%quantity)
      if (run%quantity(c) == quantity) peak = max(peak, maxval(abs(run%history(:run%samples, c))))
    end do
  end function largest_of

end module bw_load_run
