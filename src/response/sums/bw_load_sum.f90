module bw_load_sum
  !! Histories of modes under loads, and of their free motion afterwards. Between samples and knots of the loads all
  !! modes move exactly; the quasi-static contribution of omitted modes is added. Every 64 samples without a knot are
  !! also taken in one step, so that rounding does not accumulate.
  !!
  !! Up to twice the summed modes are followed. The contribution of the others, less its quasi-static part, is the first
  !! octave of the truncation error, which is extrapolated beyond it.
  use bw_double_double, only: dd, to_dd, operator(*), operator(-)
  use bw_kinds, only: dp
  use bw_load_course, only: degree_of, interval_at, load_course, next_knot, part_of_course, rates_of
  use bw_load_step, only: load_step, load_step_of
  use bw_mode_set, only: damping_rates, mode_set
  use bw_monitor, only: monitor_type
  use bw_time_grid, only: time_grid
  implicit none (type, external)
  private
  public :: rounding_of, sum_loaded_modes, tail_errors

  integer, parameter :: at_once = 64                !! samples
  integer, parameter :: orders = 2                  !! derivatives in time, the most

  type, public :: load_view
    !! The loads, and the requested quantities at points, one column each.
    integer :: summed = 0                           !! modes summed in the histories
    type(load_course), allocatable :: course(:)     !! (loads)
    real(dp), allocatable :: drive(:, :)            !! acceleration of each mode under a load of 1, (modes, loads)
    real(dp), allocatable :: weight(:, :)           !! of each mode, (modes, columns)
    real(dp), allocatable :: residual(:, :)         !! static contribution of omitted modes under a load of 1, (loads, columns)
    real(dp), allocatable :: terms(:, :)            !! magnitude of the terms that cancel in it
    integer, allocatable :: order(:)                !! time derivatives, (columns)
  end type load_view

  type, public :: load_tail
    !! Statistics of two octaves of modes, (columns, 2), and of all modes.
    real(dp), allocatable :: largest(:, :)          !! largest magnitude at a sample
    real(dp), allocatable :: squares(:, :)          !! sum of squares over the samples
    real(dp), allocatable :: amplitude(:, :)        !! largest magnitude of each mode, (modes, 0:orders)
    real(dp), allocatable :: lag(:, :)              !! the same less the quasi-static part
    real(dp), allocatable :: load(:, :)             !! the same of each load, (loads, 0:orders)
    integer :: steps = 0                            !! steps whose rounding may accumulate
  end type load_tail

contains

  subroutine sum_loaded_modes(modes, view, grid, samples, start, until, monitor, q, v, history, tail)
    !! Sum the samples of a segment, and move the state to its end.
    class(mode_set), intent(in) :: modes
    type(load_view), intent(in) :: view
    type(time_grid), intent(in) :: grid             !! of the whole record
    integer, intent(in) :: samples(2)               !! first and last, from 1
    type(dd), intent(in) :: start, until            !! of the segment
    class(monitor_type), intent(inout) :: monitor   !! the histories are invalid if it requests a stop
    real(dp), intent(inout) :: q(:), v(:)           !! state at the start, then at the end, (modes)
    real(dp), intent(inout) :: history(:, :)        !! of the whole record, (samples, columns)
    type(load_tail), intent(inout) :: tail          !! includes the segments before
    type(load_step) :: fine, coarse
    real(dp), allocatable :: c(:)
    real(dp) :: knot                                ! next knot of any load
    real(dp), dimension(modes%count) :: q_before, v_before
    real(dp) :: state(modes%count, at_once, 0:orders), load(size(view%course), at_once, 0:orders)
    real(dp), allocatable :: power(:, :)            ! of the loads in a step, (0:degree, loads)
    complex(dp) :: tone(size(view%course))
    type(dd) :: now, next
    integer :: first, held, j, m                    ! `first` of the buffered samples
    c = damping_rates(modes)
    if (.not. allocated(tail%largest)) then
      allocate (tail%largest(size(view%order), 2), tail%squares(size(view%order), 2), source=0.0_dp)
      allocate (tail%amplitude(modes%count, 0:orders), tail%lag(modes%count, 0:orders), source=0.0_dp)
      allocate (tail%load(size(view%course), 0:orders), source=0.0_dp)
    end if
    allocate (power(0:degree_of(view%course), size(view%course)))
    now = start
    knot = next_knot(view%course, now%hi)
    first = samples(1)
    held = 0                                        ! samples not yet in the histories
    j = samples(1)
    do
      if (monitor%stop_requested()) return
      next = grid%step*real(j - 1, dp)
      if (j <= samples(2) .and. next%hi < knot) then
        call step_to(next)
        call keep_sample(j)
        j = j + 1
        m = samples_to_knot()
        if (m < at_once) cycle
        call flush()
        q_before = q
        v_before = v
        if (coarse%length < 0.0_dp) coarse = step_of(grid%step*real(at_once, dp))
        next = grid%step*real(j - 2 + at_once, dp)
        call loads_until(next%hi)
        call coarse%advance(view%drive, power, tone, q_before, v_before)
        do m = 1, at_once
          call step_to(grid%step*real(j - 1, dp))
          if (m == at_once) then
            q = q_before
            v = v_before
          end if
          call keep_sample(j)
          j = j + 1
        end do
        tail%steps = tail%steps + 1
        call monitor%advance(real(j - samples(1), dp)/(samples(2) - samples(1) + 1))
      else if (knot < until%hi) then
        call step_to(to_dd(knot))
      else
        exit
      end if
    end do
    call flush()
    tail%steps = tail%steps + at_once
    next = until - now
    if (next%hi > 0.0_dp) call step_to(until)
  contains
    integer function samples_to_knot() result(many)
      !! Count the samples from the next one to the next knot.
      many = samples(2) - j + 1
      if (knot - now%hi < many*grid%step%hi) many = int((knot - now%hi)/grid%step%hi)
    end function samples_to_knot

    type(load_step) function step_of(length) result(step)
      type(dd), intent(in) :: length
      step = load_step_of(modes%beta_squared, c, length, view%course%frequency, ubound(power, 1))
    end function step_of

    subroutine loads_until(time)
      !! Set all loads in the step from now on.
      real(dp), intent(in) :: time
      integer :: l
      do l = 1, size(view%course)
        call part_of_course(view%course(l), interval_at(view%course(l), now%hi), now%hi, time, power(:, l), tone(l))
      end do
    end subroutine loads_until

    subroutine step_to(time)
      !! Step all modes to a time. Steps of one sampling interval share their operators.
      type(dd), intent(in) :: time
      type(load_step) :: odd
      type(dd) :: length
      real(dp), parameter :: same = 8.0_dp*epsilon(1.0_dp)
      length = time - now
      if (length%hi > same*time%hi) then
        call loads_until(time%hi)
        if (abs(length%hi - grid%step%hi) <= same*time%hi) then
          if (fine%length < 0.0_dp) fine = step_of(grid%step)
          call fine%advance(view%drive, power, tone, q, v)
        else
          odd = step_of(length)
          call odd%advance(view%drive, power, tone, q, v)
          tail%steps = tail%steps + 1
        end if
      end if
      now = time
      knot = next_knot(view%course, now%hi)
      if (knot - now%hi > same*now%hi) return
      now = to_dd(knot)                             ! two instants that differ by rounding
      knot = next_knot(view%course, now%hi)
    end subroutine step_to

    subroutine keep_sample(sample)
      !! Buffer the state at a sample: displacements, velocities, accelerations and loads.
      integer, intent(in) :: sample
      integer :: l
      if (held == 0) first = sample
      held = held + 1
      do l = 1, size(tone)
        call rates_of(view%course(l), interval_at(view%course(l), now%hi), now%hi, power(:, l), tone(l))
        associate (w => view%course(l)%frequency)
          load(l, held, :) = [power(0, l) + real(tone(l)), power(1, l) - w*aimag(tone(l)), -w**2*real(tone(l))]
        end associate
        if (ubound(power, 1) > 1) load(l, held, 2) = load(l, held, 2) + mean_second_derivative(view%course(l))
      end do
      state(:, held, 0) = q
      state(:, held, 1) = v
      if (any(view%order == 2)) state(:, held, 2) = matmul(view%drive, load(:, held, 0)) - c*v - modes%beta_squared%hi*q
      if (held == at_once) call flush()
    end subroutine keep_sample

    real(dp) function mean_second_derivative(course) result(bend)
      !! Return the second derivative of a load, averaged over a radian of the last summed mode: a contact force starts
      !! as t^(3/2), and no mode follows it faster.
      type(load_course), intent(in) :: course
      real(dp) :: beside(0:ubound(power, 1), 2), radian
      complex(dp) :: ignored
      integer :: i
      radian = 1.0_dp/sqrt(max(modes%beta_squared(view%summed)%hi, 1.0_dp))
      do i = 1, 2
        associate (time => now%hi + (i - 1.5_dp)*radian)
          call rates_of(course, interval_at(course, time), time, beside(:, i), ignored)
        end associate
      end do
      bend = (beside(1, 2) - beside(1, 1))/radian
    end function mean_second_derivative

    subroutine flush()
      !! Put the buffered samples into the histories, and their last octaves into the tail.
      if (held == 0) return
      call put_samples(modes, view, state(:, :held, :), load(:, :held, :), history(first:first + held - 1, :), tail)
      held = 0
    end subroutine flush
  end subroutine sum_loaded_modes

  pure subroutine put_samples(modes, view, state, load, history, tail)
    !! Sum some samples.
    class(mode_set), intent(in) :: modes
    type(load_view), intent(in) :: view
    real(dp), intent(in) :: state(:, :, 0:), load(:, :, 0:)   !! (modes or loads, samples, orders)
    real(dp), intent(inout) :: history(:, :)
    type(load_tail), intent(inout) :: tail
    real(dp) :: lag(size(state, 1), size(state, 2)), soft(size(state, 1), size(view%course))
    real(dp), allocatable :: octave(:, :)
    integer, allocatable :: columns(:)
    integer :: b, ends(3), i, k, n, o
    n = view%summed
    ends = octave_ends(n, modes%count)
    soft = view%drive                               ! static response
    do k = 1, size(soft, 1)
      associate (square => modes%beta_squared(k)%hi)
        soft(k, :) = soft(k, :)/merge(square, huge(square), square > 1.0_dp)
      end associate
    end do
    do o = 0, orders
      columns = pack([(i, i=1, size(view%order))], view%order == o)
      if (size(columns) == 0) cycle
      history(:, columns) = history(:, columns) + matmul(transpose(state(:n, :, o)), view%weight(:n, columns)) &
        + matmul(transpose(load(:, :, o)), view%residual(:, columns))
      tail%load(:, o) = max(tail%load(:, o), maxval(abs(load(:, :, o)), 2))
      tail%amplitude(:, o) = max(tail%amplitude(:, o), maxval(abs(state(:, :, o)), 2))
      lag = state(:, :, o) - matmul(soft, load(:, :, o))
      tail%lag(:, o) = max(tail%lag(:, o), maxval(abs(lag), 2))
      do b = 1, 2
        associate (first => ends(b) + 1, last => ends(b + 1))
          octave = matmul(transpose(lag(first:last, :)), view%weight(first:last, columns))
          tail%largest(columns, b) = max(tail%largest(columns, b), maxval(abs(octave), 1))
          tail%squares(columns, b) = tail%squares(columns, b) + sum(octave**2, 1)
        end associate
      end do
    end do
  end subroutine put_samples

  pure function octave_ends(summed, count) result(ends)
    !! Return the ends of octaves of modes, which start after the first and the second of these: the last summed octave
    !! and the one after it, or the last two summed ones if few more modes are known.
    integer, intent(in) :: summed, count
    integer :: ends(3)
    ends = [summed/2, summed, count]
    if (.not. knows_omitted(summed, count)) ends = [summed/4, summed/2, summed]
  end function octave_ends

  pure logical function knows_omitted(summed, count)
    !! Return whether half as many modes again are known as are summed.
    integer, intent(in) :: summed, count
    knows_omitted = 2*count >= 3*summed
  end function knows_omitted

  pure function tail_errors(view, tail, columns) result(errors)
    !! Estimate the truncation error in columns of one quantity, and its part due to unknown modes, (columns, 2). It is
    !! a geometric series with the ratio ρ of two octaves, which starts with the next octave, or with ρ times the last
    !! one if that is unknown. Waves may reach a point in higher modes only, so an octave counts at every point with its
    !! largest ratio, over all points, to the root sum of squares of modal amplitudes.
    type(load_view), intent(in) :: view
    type(load_tail), intent(in) :: tail
    integer, intent(in) :: columns(:)
    real(dp) :: errors(size(columns), 2), error(size(columns))
    real(dp), parameter :: least = 0.02_dp, most = 0.9_dp, margin = 2.0_dp   ! tuned
    real(dp) :: part, ratio, scale(size(columns), 2)
    integer :: b, ends(3), i
    ends = octave_ends(view%summed, size(view%drive, 1))
    do b = 1, 2
      do i = 1, size(columns)
        associate (k => [ends(b) + 1, ends(b + 1)], o => view%order(columns(i)))
          scale(i, b) = norm2(view%weight(k(1):k(2), columns(i))*tail%lag(k(1):k(2), o))
        end associate
      end do
    end do
    ratio = most
    associate (squares => sum(tail%squares(columns, :), 1))
      if (squares(1) > 0.0_dp) ratio = min(most, max(least, sqrt(squares(2)/squares(1))))
    end associate
    part = maxval(tail%largest(columns, :)/max(scale, tiny(1.0_dp)))
    error = margin/(1.0_dp - ratio)*part*max(scale(:, 2), ratio*scale(:, 1))
    if (.not. knows_omitted(view%summed, size(view%drive, 1))) error = 2.0_dp*max(ratio, 0.1_dp)*error
    errors = reshape([error, ratio*error], shape(errors))
  end function tail_errors

  pure function rounding_of(modes, view, tail, duration) result(error)
    !! Return rounding errors due to steps, frequencies, modal masses and residuals, (columns).
    class(mode_set), intent(in) :: modes
    type(load_view), intent(in) :: view
    type(load_tail), intent(in) :: tail
    real(dp), intent(in) :: duration                !! of the record, l²/h
    real(dp) :: error(size(view%order))
    real(dp), parameter :: static_rounding = 4.0_dp*epsilon(1.0_dp)   ! of each term of a residual
    real(dp), dimension(modes%count) :: square_error, mass_error, part
    integer :: i
    call modes%number_errors(square_error, mass_error)
    part = epsilon(1.0_dp)*tail%steps + mass_error + 0.5_dp*duration*square_error/sqrt(max(abs(modes%beta_squared%hi), 1.0_dp))
    do i = 1, size(error)
      error(i) = static_rounding*sum(view%terms(:, i)*tail%load(:, view%order(i))) &
        + sum(abs(view%weight(:, i))*tail%amplitude(:, view%order(i))*part)
    end do
  end function rounding_of

end module bw_load_sum
