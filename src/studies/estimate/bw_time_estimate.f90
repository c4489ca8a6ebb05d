module bw_time_estimate
  !! How long a scene will take, and what it will warn of: samples of its cases are run for a bounded time.
  use bw_case_result, only: case_result
  use bw_case_shares, only: case_seconds, case_shares, histories_share
  use bw_error, only: error_type
  use bw_forecast, only: forecast_type, most_trial_bytes
  use bw_kinds, only: dp, i8
  use bw_monitor, only: monitor_type
  use bw_one_case, only: case_cache, run_case
  use bw_process, only: free_memory
  use bw_result_layout, only: result_layout
  use bw_scene, only: scene_type
  use bw_scene_cases, only: case_count, case_scene
  use bw_scene_summary, only: case_numbers, working_bytes
  use bw_stopwatch, only: stopwatch, wall_seconds
  implicit none (type, external)
  private
  public :: estimated_seconds, fits

  integer, parameter :: most_samples = 200
  real(dp), parameter :: least_part = 0.02_dp       !! of a case, from which the whole can be told; else the model is asked
  real(dp), parameter :: quick = 0.02_dp                   !! of the time there is: a case before which another one may be run
  real(dp), parameter :: least_look = 0.1_dp               !! s for histories, however long their modes took
  real(dp), parameter :: golden = 0.6180339887498949_dp    !! its multiples fill 0 … 1 evenly, however many are taken
  real(dp), parameter :: start_seconds = 2.5e-2_dp         !! of the program itself, most of them its libraries'; measured
  real(dp), parameter :: file_seconds = 2.0e-3_dp          !! of a result's names and attributes; measured
  real(dp), parameter :: put_seconds = 2.5e-6_dp           !! of a case into the result; measured
  real(dp), parameter :: number_seconds = 3.0e-8_dp        !! of each of its numbers; 2e-8 measured of 0.1 GB, 4e-8 of 0.5 GB

  type, extends(monitor_type) :: time_limit
    !! Stops when the time is up, or its user asks to, and remembers how much of the case was done.
    class(monitor_type), pointer :: user => null()
    real(dp) :: deadline = 0.0_dp
    real(dp) :: histories = 0.0_dp            !! the part of the case that comes before its histories
    real(dp) :: fraction = 0.0_dp             !! of the case that was done
    real(dp) :: before = 0.0_dp               !! s of the processor when the first part of its histories was done; 0: not yet
    real(dp) :: first = 0.0_dp                !! that part
  contains
    procedure :: start
    procedure :: advance
    procedure :: stop_requested
  end type time_limit

  type :: case_timer
    !! What is at hand while cases are run for their time.
    type(scene_type) :: scene
    type(result_layout) :: layout
    type(scene_type) :: one                   !! the case at hand, or the one before it
    integer(i8) :: index = 0                  !! its number
    type(case_cache) :: cache                  !! what cases share
    type(time_limit) :: limit
    type(forecast_type) :: forecast
  contains
    procedure :: sample, guess, predict_notes
  end type case_timer

contains

  real(dp) function estimated_seconds(scene, layout, budget, monitor, forecast) result(seconds)
    !! Wall time of all cases by one process on a core of its own, s: the processor time of some of them, which other work
    !! on the machine changes least.
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    real(dp), intent(in) :: budget                !! what the estimate may take itself, s
    class(monitor_type), intent(inout), target :: monitor    !! the estimate means nothing where it asks to stop
    type(forecast_type), intent(out) :: forecast
    type(case_timer) :: timer
    real(dp) :: spent, began, part
    integer(i8) :: bytes, free, numbers           ! the last of a case
    logical :: whole
    allocate (timer%forecast%cases(0))
    timer%scene = scene
    timer%layout = layout
    timer%limit%user => monitor
    began = wall_seconds()
    bytes = working_bytes(scene, layout)
    numbers = case_numbers(scene, layout)
    free = free_memory()
    if (bytes <= most_trial_bytes .and. fits(bytes, free)) then
      call timer%sample(1_i8, began + budget, part, spent)   ! a first case finds caches and plans empty
    else
      call timer%guess(part, spent)
    end if
    seconds = spent/part
    whole = part >= 1.0_dp
    if (whole .and. case_count(scene) > 1) call sample_sweep(timer, budget, began, spent < quick*budget, seconds)
    if (.not. any(timer%forecast%cases == timer%index)) call timer%predict_notes(monitor)
    forecast = timer%forecast
    seconds = start_seconds + file_seconds + case_count(scene)*(seconds + put_seconds + number_seconds*numbers)
  end function estimated_seconds

  subroutine sample_sweep(timer, budget, began, is_quick, seconds)
    !! The mean processor time of cases that lie all over a sweep.
    type(case_timer), intent(inout) :: timer
    real(dp), intent(in) :: budget                !! s since `began`, after which no other case is begun
    real(dp), intent(in) :: began                 !! on the clock of `wall_seconds`
    logical, intent(in) :: is_quick               !! there is time to run the case before each sample too
    real(dp), intent(out) :: seconds
    real(dp) :: spent, part
    integer(i8) :: cases, index
    integer :: samples
    cases = case_count(timer%scene)
    samples = 0
    seconds = 0.0_dp
    if (is_quick) call timer%sample(cases, began + 2.0_dp*budget, part, spent)       ! what is extreme is often the last
    do while (samples < min(cases, int(most_samples, i8)))
      samples = samples + 1
      index = place(samples, cases)
      ! a case shares work with the one before it
      if (is_quick .and. index > 1) call timer%sample(index - 1, began + 2.0_dp*budget, part, spent)
      call timer%sample(index, wall_seconds() + budget, part, spent)
      seconds = seconds + spent/part
      if (wall_seconds() - began > budget) exit
      if (timer%limit%user%stop_requested()) exit
    end do
    seconds = seconds/samples
  end subroutine sample_sweep

  elemental logical function fits(wanted, free)
    !! As much is free as is wanted, as far as is known.
    integer(i8), intent(in) :: wanted, free       !! bytes; below 0: not known
    fits = free < 0 .or. wanted <= free
  end function fits

  subroutine guess(self, part, spent)
    !! In place of a sample of the first case, which takes more memory than there is for it.
    class(case_timer), intent(inout) :: self
    real(dp), intent(out) :: part, spent          !! as those of `sample`, of nothing of the case
    type(error_type), allocatable :: error
    self%index = 1
    call case_scene(self%scene, self%index, self%one, error)
    spent = case_seconds(self%one)
    part = nearest(1.0_dp, -1.0_dp)
  end subroutine guess

  subroutine predict_notes(self, monitor)
    !! What few modes and samples say of the case at hand, which was not run to its end, and of the last: what is extreme is often
    !! the last.
    class(case_timer), intent(inout) :: self
    class(monitor_type), intent(inout) :: monitor !! nothing is predicted where it asks to stop
    type(error_type), allocatable :: error
    call self%forecast%predict_notes(self%index, self%one, self%layout, monitor)
    self%index = case_count(self%scene)
    call case_scene(self%scene, self%index, self%one, error)
    if (.not. allocated(error)) call self%forecast%predict_notes(self%index, self%one, self%layout, monitor)
  end subroutine predict_notes

  pure integer(i8) function place(sample, cases)
    !! The number of the case that is the n-th sample.
    integer, intent(in) :: sample
    integer(i8), intent(in) :: cases
    real(dp) :: position
    position = sample*golden
    place = 1 + min(cases - 1, int((position - floor(position))*real(cases, dp), i8))
  end function place

  subroutine sample(self, index, deadline, part, spent)
    !! Run a case, or the part of it that there is time for.
    class(case_timer), intent(inout) :: self
    integer(i8), intent(in) :: index              !! of the case, from 1
    real(dp), intent(in) :: deadline              !! on the clock of `wall_seconds`
    real(dp), intent(out) :: part                 !! of the case that was done, above 0, at most 1
    real(dp), intent(out) :: spent                !! s of the processor
    type(stopwatch) :: watch
    type(case_result) :: result
    type(error_type), allocatable :: error
    real(dp) :: began, ended
    logical :: whole
    call cpu_time(began)
    whole = .true.
    self%index = index
    call case_scene(self%scene, index, self%one, error)
    call self%limit%start(self%one, deadline)
    if (.not. allocated(error)) call run_case(self%one, self%layout, watch, self%limit, self%cache, result, whole)
    call cpu_time(ended)
    spent = ended - began
    part = 1.0_dp
    if (whole .and. .not. allocated(error)) call self%forecast%add(index, result%notes)
    if (whole) return
    associate (limit => self%limit)
      if (limit%fraction > 1.0_dp - least_part) then                   ! errors take as long as they may
        spent = 2.0_dp*spent
      else if (limit%before > 0.0_dp .and. limit%fraction > limit%first + least_part*(1.0_dp - limit%first)) then
        ! what comes before the histories is not a part of them
        spent = (limit%before - began) + (ended - limit%before)*((1.0_dp - limit%first)/(limit%fraction - limit%first))
      else if (limit%before <= 0.0_dp .and. limit%fraction > least_part) then
        part = limit%fraction
      else
        spent = max(2.0_dp*spent, case_seconds(self%one))
      end if
    end associate
  end subroutine sample

  subroutine start(self, scene, deadline)
    !! Call this before a case.
    class(time_limit), intent(inout) :: self
    type(scene_type), intent(in) :: scene         !! without sweeps
    real(dp), intent(in) :: deadline              !! on the clock of `wall_seconds`
    real(dp), allocatable :: share(:)
    share = case_shares(scene)
    self%histories = sum(share(:histories_share - 1))
    self%deadline = deadline
    self%fraction = 0.0_dp
    self%before = 0.0_dp
  end subroutine start

  subroutine advance(self, fraction)
    !! Remember how much of the case is done, and when its histories began.
    class(time_limit), intent(inout) :: self
    real(dp), intent(in) :: fraction
    if (self%before <= 0.0_dp .and. fraction > self%histories) then
      call cpu_time(self%before)
      self%first = fraction
      self%deadline = max(self%deadline, wall_seconds() + least_look)
    end if
    self%fraction = fraction
  end subroutine advance

  logical function stop_requested(self)
    !! The time is up, or the user asks to stop.
    class(time_limit), intent(inout) :: self
    stop_requested = wall_seconds() > self%deadline
    if (.not. stop_requested) stop_requested = self%user%stop_requested()
  end function stop_requested

end module bw_time_estimate
