module bw_direct_motion
  !! The motion of a scene within a tolerance at a few samples by direct sums, every root in extended precision: what the
  !! converged run is checked against.
  !!
  !! At a release every mode of beam and mass is handed on to each of the beam alone, of far more of them than move after it:
  !! what the run takes those far above to be, one blow at the tip, is left for those beyond these alone.
  use bw_beam_units, only: beam_units, units_of
  use bw_case_modes, only: find_modes
  use bw_case_result, only: case_modes, case_result, mode_sources, release_plan
  use bw_direct_sum, only: add_directly
  use bw_double_double, only: dd, operator(*), operator(-)
  use bw_impact, only: continuum_velocity
  use bw_kinds, only: dp
  use bw_mode_set, only: first_numbers, mode_set, mode_source
  use bw_monitor, only: monitor_type
  use bw_scene, only: scene_type
  use bw_segment, only: move
  use bw_time_grid, only: first_sample, time_grid, time_grid_of
  implicit none (type, external)
  private
  public :: sum_directly

  integer, parameter :: batch = 4096            !! modes held at a time
  integer, parameter :: wider = 3               !! so many times the modes that move after a release are handed on to them
  real(dp), parameter :: endless = huge(1.0_dp) !! a record that calls for extended precision in every root

contains

  subroutine sum_directly(scene, run, sample, monitor, displacement, whole)
    !! Displacements, m, of the continuum's modes as a run chose their numbers.
    type(scene_type), intent(in) :: scene                      !! its modes in closed form
    type(case_result), intent(in) :: run                       !! of this scene
    integer, intent(in) :: sample(:)                           !! numbers of samples, from 0, ascending
    class(monitor_type), intent(inout) :: monitor
    type(dd), allocatable, intent(out) :: displacement(:, :)   !! (samples, points)
    logical, intent(out) :: whole                              !! false where the monitor asked to stop
    type(case_modes) :: modes
    type(mode_sources) :: sources
    type(beam_units) :: units
    type(time_grid) :: grid
    type(dd) :: times(size(sample))
    real(dp) :: unit
    integer :: early
    allocate (displacement(size(sample), size(scene%response%points)), source=dd(0.0_dp, 0.0_dp))
    units = units_of(scene%beam)
    call find_modes(scene, units, monitor, modes, sources)
    whole = .not. monitor%stop_requested()
    if (.not. whole) return
    grid = time_grid_of(scene%response%duration, scene%response%samples, units%time)
    times = grid%step*real(sample, dp)
    early = size(sample)
    if (allocated(run%release)) early = count(sample < first_sample(run%release%time, grid) - 1)
    unit = scene%impact%approach_velocity*units%time%hi
    call add_captured(scene, sources%loaded, run%mode_count, unit, times(:early), monitor, displacement(:early, :), whole)
    if (.not. whole .or. early == size(sample)) return
    call add_released(scene, sources, run%release, unit, times(early + 1:) - run%release%time, monitor, &
                      displacement(early + 1:, :), whole)
  end subroutine sum_directly

  subroutine add_captured(scene, source, count, unit, times, monitor, displacement, whole)
    type(scene_type), intent(in) :: scene
    class(mode_source), intent(in) :: source                   !! of beam and mass
    integer, intent(in) :: count                               !! modes
    real(dp), intent(in) :: unit                               !! V l²/h, m
    type(dd), intent(in) :: times(:)                           !! l²/h
    class(monitor_type), intent(inout) :: monitor
    type(dd), intent(inout) :: displacement(:, :)              !! (times, points)
    logical, intent(out) :: whole
    class(mode_set), allocatable :: modes
    integer :: first
    do first = 1, count, batch
      whole = .not. monitor%stop_requested()
      if (.not. whole) return
      call source%find(batch_from(first, count), modes, endless)
      call add_directly(modes, started(scene, modes)*unit, scene%response%points, times, displacement)
    end do
  end subroutine add_captured

  subroutine add_released(scene, sources, release, unit, times, monitor, displacement, whole)
    type(scene_type), intent(in) :: scene
    type(mode_sources), intent(in) :: sources
    type(release_plan), intent(in) :: release                  !! of the run
    real(dp), intent(in) :: unit
    type(dd), intent(in) :: times(:)                           !! from the release, l²/h
    class(monitor_type), intent(inout) :: monitor
    type(dd), intent(inout) :: displacement(:, :)
    logical, intent(out) :: whole
    class(mode_set), allocatable :: free, loaded
    real(dp) :: q(release%count), rate(release%count), rest(2)
    integer :: first, last
    call sources%free%find(first_numbers(release%count), free, endless, monitor)
    q = 0.0_dp
    rate = 0.0_dp
    rest = [release%tip%displacement, release%tip%velocity]
    last = max(release%count, min(wider*release%count, release%tip%count))
    do first = 1, last, batch
      whole = .not. monitor%stop_requested()
      if (.not. whole) return
      call sources%loaded%find(batch_from(first, last), loaded, endless)
      call hand_on(scene, loaded, first, release, free, q, rate, rest)
    end do
    q = (q - sources%loaded%gamma*rest(1)*free%tip)/free%modal_mass
    rate = (rate - sources%loaded%gamma*rest(2)*free%tip)/free%modal_mass
    call add_directly(free, rate*unit, scene%response%points, times, displacement, displaced=q*unit)
  end subroutine add_released

  subroutine hand_on(scene, loaded, first, release, free, q, rate, rest)
    !! Adds what some modes of beam and mass do at the release to modes of the beam alone; what the run took them to add at
    !! the tip is taken off the rest.
    type(scene_type), intent(in) :: scene
    class(mode_set), intent(in) :: loaded, free
    integer, intent(in) :: first                               !! number of the first of `loaded`
    type(release_plan), intent(in) :: release
    real(dp), intent(inout) :: q(:), rate(:)                   !! times the modal masses, (modes)
    real(dp), intent(inout) :: rest(2)                         !! displacement and velocity of the tip
    real(dp), dimension(loaded%count) :: moved, moved_rate
    integer :: beyond
    moved = 0.0_dp
    moved_rate = started(scene, loaded)
    call move(loaded, release%time, moved, moved_rate)
    q = q + free%overlap_of_beam(loaded, moved)
    rate = rate + free%overlap_of_beam(loaded, moved_rate)
    beyond = max(1, release%count - first + 2)            ! place of the first that does not move after it
    rest(1) = rest(1) - dot_product(loaded%tip(beyond:), moved(beyond:))
    rest(2) = rest(2) - dot_product(loaded%tip(beyond:), moved_rate(beyond:))
  end subroutine hand_on

  pure function started(scene, modes) result(rate)
    !! Velocities just after the capture, V.
    type(scene_type), intent(in) :: scene
    class(mode_set), intent(in) :: modes
    real(dp) :: rate(modes%count)
    rate = continuum_velocity(modes, scene%impact%mass_ratio, scene%impact%restitution)
  end function started

  pure function batch_from(first, last) result(number)
    !! The numbers of some modes, of no more than `batch`.
    integer, intent(in) :: first, last
    integer :: number(min(batch, last - first + 1))
    number = first - 1 + first_numbers(size(number))
  end function batch_from

end module bw_direct_motion
