module bw_direct_motion
  !! The motion of a scene within a tolerance at chosen samples by direct sums, every root in extended precision: what the
  !! converged run is checked against.
  !!
  !! At a release every mode of beam and mass is handed on to each of the beam alone, far more of them than move after it:
  !! what the run takes modes far above to be, one blow at the tip, is taken here of those beyond these only.
  use bw_beam_units, only: beam_units, units_of
  use bw_case_modes, only: find_modes
  use bw_case_result, only: case_modes, case_result
  use bw_direct_sum, only: add_directly
  use bw_double_double, only: dd, operator(*), operator(-)
  use bw_impact, only: continuum_velocity
  use bw_kinds, only: dp
  use bw_mode_set, only: configuration_type, first_numbers, mode_set
  use bw_monitor, only: monitor_type
  use bw_scene, only: scene_type
  use bw_segment, only: move, segment_type
  use bw_time_grid, only: first_sample, time_grid, time_grid_of
  implicit none (type, external)
  private
  public :: sum_directly

  integer, parameter :: batch = 4096            !! modes at a time
  real(dp), parameter :: endless = huge(1.0_dp) !! a record that calls for extended precision in every root

  type :: direct_type
    !! What a direct sum takes its modes from.
    type(scene_type) :: scene
    type(configuration_type), allocatable :: configuration(:)
    real(dp) :: unit = 0.0_dp                    !! of displacements: V l²/h, m
  contains
    procedure :: add_captured
    procedure :: add_released
    procedure :: hand_on
    procedure :: started
  end type direct_type

  type :: released_type
    !! The modes of the beam alone, and how they move just after the release.
    class(mode_set), allocatable :: modes
    real(dp), allocatable :: q(:), rate(:)       !! displacements and velocities times the modal masses, (modes)
    real(dp) :: beyond(2) = 0.0_dp               !! displacement and velocity of the tip by modes of beam and mass far beyond these
  end type released_type

contains

  subroutine sum_directly(scene, run, sample, monitor, displacement, whole)
    !! Sum the displacements of as many modes as a run has chosen.
    type(scene_type), intent(in) :: scene                      !! its modes in closed form
    type(case_result), intent(in) :: run                       !! of this scene
    integer, intent(in) :: sample(:)                           !! numbers of samples, from 0, ascending
    class(monitor_type), intent(inout) :: monitor
    type(dd), allocatable, intent(out) :: displacement(:, :)   !! (samples, points)
    logical, intent(out) :: whole                              !! false where the monitor asked to stop
    type(direct_type) :: direct
    type(case_modes) :: modes
    type(beam_units) :: units
    type(time_grid) :: grid
    type(dd) :: times(size(sample))
    integer :: early
    allocate (displacement(size(sample), size(scene%response%points)), source=dd(0.0_dp, 0.0_dp))
    units = units_of(scene%beam)
    call find_modes(scene, units, monitor, modes)
    whole = .not. monitor%stop_requested()
    if (.not. whole) return
    call move_alloc(modes%configuration, direct%configuration)
    direct%scene = scene
    direct%unit = scene%impact%approach_velocity*units%time%hi
    grid = time_grid_of(scene%response%duration, scene%response%samples, units%time)
    times = grid%step*real(sample, dp)
    early = size(sample)
    if (size(run%segments) > 1) early = count(sample < first_sample(run%segments(2)%start, grid) - 1)
    call direct%add_captured(run%segments(1), times(:early), monitor, displacement(:early, :), whole)
    if (.not. whole .or. early == size(sample)) return
    call direct%add_released(run%segments(1), run%segments(2), times(early + 1:) - run%segments(2)%start, monitor, &
                             displacement(early + 1:, :), whole)
  end subroutine sum_directly

  subroutine add_captured(self, segment, times, monitor, displacement, whole)
    !! Add the motion of beam and mass together.
    class(direct_type), intent(in) :: self
    type(segment_type), intent(in) :: segment
    type(dd), intent(in) :: times(:)                           !! from the impact, l²/h
    class(monitor_type), intent(inout) :: monitor
    type(dd), intent(inout) :: displacement(:, :)              !! m, (times, points)
    logical, intent(out) :: whole                              !! false where the monitor asked to stop
    class(mode_set), allocatable :: modes
    integer :: first
    do first = 1, segment%count, batch
      whole = .not. monitor%stop_requested()
      if (.not. whole) return
      call self%configuration(segment%configuration)%source%find(batch_from(first, segment%count), modes, endless)
      call add_directly(modes, self%started(modes)*self%unit, self%scene%response%points, times, displacement)
    end do
  end subroutine add_captured

  subroutine add_released(self, before, after, times, monitor, displacement, whole)
    !! Add the motion of the beam after the mass has left it.
    class(direct_type), intent(in) :: self
    type(segment_type), intent(in) :: before, after            !! of the run
    type(dd), intent(in) :: times(:)                           !! from the release, l²/h
    class(monitor_type), intent(inout) :: monitor
    type(dd), intent(inout) :: displacement(:, :)              !! m, (times, points)
    logical, intent(out) :: whole                              !! false where the monitor asked to stop
    type(released_type) :: released
    class(mode_set), allocatable :: loaded
    integer :: first
    associate (source => self%configuration(before%configuration)%source)
      call self%configuration(after%configuration)%source%find(first_numbers(after%count), released%modes, endless, monitor)
      allocate (released%q(after%count), released%rate(after%count), source=0.0_dp)
      do first = 1, after%handed, batch
        whole = .not. monitor%stop_requested()
        if (.not. whole) return
        call source%find(batch_from(first, after%handed), loaded, endless)
        call self%hand_on(loaded, first, after, released)
      end do
      associate (q => released%q, rate => released%rate, modes => released%modes)
        q = (q - source%gamma*released%beyond(1)*modes%struck)/modes%modal_mass
        rate = (rate - source%gamma*released%beyond(2)*modes%struck)/modes%modal_mass
        call add_directly(modes, rate*self%unit, self%scene%response%points, times, displacement, displaced=q*self%unit)
      end associate
    end associate
  end subroutine add_released

  subroutine hand_on(self, loaded, first, after, released)
    !! Add what a batch of modes of beam and mass do at the release to the modes of the beam alone: by their overlaps with each, and of
    !! modes far above all of these as one blow.
    class(direct_type), intent(in) :: self
    class(mode_set), intent(in) :: loaded
    integer, intent(in) :: first                               !! number of the first of `loaded`
    type(segment_type), intent(in) :: after                    !! of the run
    type(released_type), intent(inout) :: released
    integer, parameter :: far = 16                             ! times the modes after: the rest is off by far**(-4)
    real(dp), dimension(loaded%count) :: moved, moved_rate
    moved = 0.0_dp
    moved_rate = self%started(loaded)
    call move(loaded, after%start, moved, moved_rate)
    if (first <= max(far*after%count, batch)) then
      released%q = released%q + released%modes%overlap_of_beam(loaded, moved)
      released%rate = released%rate + released%modes%overlap_of_beam(loaded, moved_rate)
    else
      released%beyond = released%beyond + [dot_product(loaded%struck, moved), dot_product(loaded%struck, moved_rate)]
    end if
  end subroutine hand_on

  pure function started(self, modes) result(rate)
    !! The modes' velocities just after the capture, V.
    class(direct_type), intent(in) :: self
    class(mode_set), intent(in) :: modes
    real(dp) :: rate(modes%count)
    rate = continuum_velocity(modes, self%scene%impact%mass_ratio, self%scene%impact%restitution)
  end function started

  pure function batch_from(first, last) result(number)
    !! The numbers of some modes, of no more than `batch`.
    integer, intent(in) :: first, last
    integer :: number(min(batch, last - first + 1))
    number = first - 1 + first_numbers(size(number))
  end function batch_from

end module bw_direct_motion
