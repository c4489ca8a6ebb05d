module bw_line_drops
  !! Lines that gain less than their penalty are dropped, with the noise renewed on both sides of the comparison.
  use bw_cost, only: akaike, cost_of_all, order_price, penalty_of_line
  use bw_kinds, only: dp
  use bw_line, only: life_of, line_type
  use bw_model, only: find_misfit, model_type
  use bw_monitor, only: monitor_type, stops
  use bw_noise, only: white_amplitude
  use bw_noise_alone, only: most_colour, most_orders
  use bw_order, only: ascending
  use bw_refit, only: all_steps, near, negligible_gain, refit, refit_all, refit_type, trial_steps
  use bw_renewal, only: highest_order, renew
  use bw_samples, only: samples_type, validity
  implicit none (type, external)
  private
  public :: clear_if_growing, drop_lines, drop_weakest, energy_of, keep_or_clear

  real(dp), parameter :: sure = 2                !! penalties of a line; if a bound of its gain is lower, the gain is computed

  type, public :: line_outcome
    !! How a search ended.
    logical :: converged = .true.                !! no move lowers J any more
    logical :: driven = .false.                  !! noise alone explains the motion better than all lines found
    integer :: contact = 0                       !! samples left out after each blow
    complex(dp), allocatable :: poles(:)         !! of the last candidates, or of lines that noise alone explains
    real(dp), allocatable :: gains(:)            !! their decreases of the squares, over the noise's variance
  end type line_outcome

  type :: drop_type
    !! What replaces lines if a line or a course is dropped.
    complex(dp), allocatable :: old(:)           !! poles of the lines that are replaced
    type(line_type), allocatable :: lines(:)     !! which take their place
    real(dp) :: rise = 0                         !! of J
  end type drop_type

contains

  subroutine keep_or_clear(samples, false_alarm, alone, share, model, outcome)
    !! Drop all lines unless they gain more over coloured noise alone than a share of what decaying lines do: otherwise the motion
    !! is driven.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    real(dp), intent(in) :: alone                !! J of noise alone
    real(dp), intent(in) :: share
    type(model_type), intent(inout) :: model
    type(line_outcome), intent(inout) :: outcome
    real(dp) :: gain
    if (size(model%lines) == 0 .or. .not. alone < huge(alone)) return
    call renew(samples, akaike, .false., model, most_orders(samples, most_colour, 1))
    gain = alone - cost_of_all(samples, false_alarm, model)
    call renew(samples, order_price(samples), .false., model)
    if (gain <= share*usual_gain(samples, false_alarm, model)) call clear(samples, model, outcome)
  end subroutine keep_or_clear

  pure real(dp) function usual_gain(samples, false_alarm, model) result(gain)
    !! What lines gain over noise alone, less their penalties. From p samples, K tones of energy E are predicted with errors of
    !! 1 + (E/N)/(1 + Ep/(2KN)) times the noise's variance. With 2 for each coefficient this costs at least T − T²/(4E), where
    !! T = 4(KN)^½, or E if that is less than T/2. Lines that decay count while they live; more sensors can only gain more.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    type(model_type), intent(in) :: model
    real(dp) :: tones, energy
    integer :: k
    tones = 4*sqrt(sum([(life_of(model%lines(k), 1.0_dp, real(samples%count, dp)), k=1, size(model%lines))]))
    energy = sum([(energy_of(model, model%lines(k)), k=1, size(model%lines))])
    gain = energy
    if (energy > tones/2) gain = tones - tones**2/(4*energy)
    gain = max(0.0_dp, gain - (cost_of_all(samples, false_alarm, model) - model%noise%cost))
  end function usual_gain

  subroutine clear_if_growing(samples, model, outcome)
    !! Drop all lines if their residual grows after the first blow to a considerable part of the motion. What lines leave of a free
    !! decay decays with it, and noise that rises is small beside a motion that stands out; but of a motion that is driven, as by a
    !! shaker's sweep, lines leave most where it is strong.
    type(samples_type), intent(in) :: samples
    type(model_type), intent(inout) :: model
    type(line_outcome), intent(inout) :: outcome
    integer, parameter :: parts = 8, fewest = 32 ! samples in a part: fewer vary by chance
    real(dp), parameter :: grows = 10            ! chosen: drawn sweeps have 20 and more
    real(dp), parameter :: considerable = 0.1_dp ! chosen: of the power of the motion in the same part
    real(dp) :: residual(samples%count, 1), own(parts), energy(parts), share(parts)
    logical :: valid(samples%count)
    integer :: s, i, length, first
    first = model%stretches(1, 1)
    length = (samples%count - first + 1)/parts
    if (length < fewest .or. size(model%lines) == 0) return
    energy = 0
    share = 0
    do s = 1, size(samples%value, 2)
      call find_misfit(samples, model, [s], residual)
      valid = validity(samples, s)
      do i = 1, parts
        associate (from => first + (i - 1)*length, to => first + i*length - 1)
          associate (x => samples%value(from:to, s), is_there => valid(from:to))
            own(i) = sum(residual(from:to, 1)**2, is_there)/max(1, count(is_there))
            share(i) = share(i) + own(i)/max(sum((x - sum(x, is_there)/max(1, count(is_there)))**2, is_there) &
              & /max(1, count(is_there)), tiny(1.0_dp))/size(samples%value, 2)
          end associate
        end associate
      end do
      energy = energy + own/max(sum(own), tiny(1.0_dp))
    end do
    if (any(energy > grows*energy(1) .and. share > considerable)) call clear(samples, model, outcome)
  end subroutine clear_if_growing

  subroutine clear(samples, model, outcome)
    !! Drop all lines, and report a driven motion.
    type(samples_type), intent(in) :: samples
    type(model_type), intent(inout) :: model
    type(line_outcome), intent(inout) :: outcome
    integer :: k
    outcome%driven = .true.
    outcome%poles = model%lines%pole
    outcome%gains = [(energy_of(model, model%lines(k)), k=1, size(model%lines))]
    model%lines = model%lines(:0)
    call renew(samples, order_price(samples), .false., model)
  end subroutine clear

  subroutine drop_lines(samples, false_alarm, model, dropped, monitor)
    !! Drop lines and courses that gain less than their penalty with the best coloured noise: first those whose loss lowers J most,
    !! then others that do not overlap with them.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    type(model_type), intent(inout) :: model
    integer, intent(out) :: dropped
    class(monitor_type), intent(inout), optional :: monitor
    type(drop_type), allocatable :: drop(:)
    type(line_type), allocatable :: all_of(:)
    real(dp) :: before                           !! J
    integer :: i, k
    call drop_weakest(samples, false_alarm, model, dropped)
    all_of = model%lines
    before = cost_of_all(samples, false_alarm, model)
    drop = [drop_type ::]
    do k = 1, size(all_of)
      if (least_rise(model, all_of(k)) < sure*penalty_of_line(samples, false_alarm, model)) &
        & drop = [drop, drop_of(model, k, .false.)]
      if (size(all_of(k)%courses) > 0) drop = [drop, drop_of(model, k, .true.)]
    end do
    do i = 1, size(drop)
      if (stops(monitor)) return
      call try(drop(i))
      drop(i)%rise = cost_of_all(samples, false_alarm, model) - before
      model%lines = all_of
    end do
    call renew(samples, order_price(samples), .false., model)
    do while (any(drop%rise < 0))
      i = minloc(drop%rise, dim=1)
      all_of = model%lines
      before = cost_of_all(samples, false_alarm, model)
      if (all([(any(abs(all_of%pole - drop(i)%old(k)) <= 0), k=1, size(drop(i)%old))])) then
        call try(drop(i))
        if (cost_of_all(samples, false_alarm, model) < before) then
          dropped = dropped + 1
        else
          model%lines = all_of
          call renew(samples, order_price(samples), .false., model)
        end if
      end if
      drop(i)%rise = 0
    end do

  contains

    subroutine try(drop)
      !! Drop a line or a course, with the noise renewed.
      type(drop_type), intent(in) :: drop
      integer :: k
      model%lines = [pack(model%lines, [(all(abs(drop%old - model%lines(k)%pole) > 0), k=1, size(model%lines))]), drop%lines]
      call renew(samples, order_price(samples), .false., model)
    end subroutine try

  end subroutine drop_lines

  subroutine drop_weakest(samples, false_alarm, model, dropped)
    !! Drop as many of the weakest lines as minimises J, with the others unchanged.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    type(model_type), intent(inout) :: model
    integer, intent(out) :: dropped
    type(line_type) :: by_energy(size(model%lines))
    real(dp) :: energy(size(model%lines)), least, cost
    integer :: k, n
    n = size(model%lines)
    dropped = 0
    do k = 1, n
      energy(k) = energy_of(model, model%lines(k))
    end do
    by_energy = model%lines(ascending(energy))
    least = cost_of_all(samples, false_alarm, model)
    do k = 1, n
      if (least_rise(model, by_energy(k)) > sure*k*penalty_of_line(samples, false_alarm, model)) exit
      model%lines = by_energy(k + 1:)
      call renew(samples, order_price(samples), .false., model)
      if (model%noise%cost >= least) exit        ! fewer lines do not make the noise cheaper either
      cost = cost_of_all(samples, false_alarm, model)
      if (cost >= least) cycle
      least = cost
      dropped = k
    end do
    if (size(model%lines) == n) return           ! no drop was tried
    model%lines = by_energy(dropped + 1:)
    call renew(samples, order_price(samples), .false., model)
    if (dropped > 0) call refit_all(all_steps, negligible_gain, model)
    if (dropped > 0) call renew(samples, order_price(samples), .false., model)
  end subroutine drop_weakest

  pure real(dp) function energy_of(model, line) result(energy)
    !! The approximate sum of squares of a line's white samples.
    type(model_type), intent(in) :: model
    type(line_type), intent(in) :: line
    complex(dp) :: white(size(line%amplitude, 1), size(line%amplitude, 2))
    integer :: b
    white = white_amplitude(model%noise, line)
    energy = 0
    do b = 0, ubound(model%stretches, 2)
      associate (n => real(model%stretches(2, b) - model%stretches(1, b) + 1, dp))
        energy = energy + sum(abs(white(:, b + 1))**2)/2*life_of(line, 0.5_dp, max(n, 0.0_dp))
      end associate
    end do
  end function energy_of

  pure real(dp) function least_rise(model, line) result(toll)
    !! A lower bound of the rise of J if noise alone has to explain a line: the error of a prediction from p samples has 1 + ρ/(1 +
    !! ρp/2) times the noise's variance if a line has ρ times the power of white noise.
    type(model_type), intent(in) :: model
    type(line_type), intent(in) :: line
    complex(dp) :: white(size(line%amplitude, 1), size(line%amplitude, 2))
    real(dp) :: power(size(white, 1))
    integer :: b
    white = white_amplitude(model%noise, line)
    toll = 0
    do b = 0, ubound(model%stretches, 2)
      associate (n => real(model%stretches(2, b) - model%stretches(1, b) + 1, dp))
        power = abs(white(:, b + 1))**2/(2*exp(2.0_dp))    ! at the end of its first decay time
        toll = toll + sum(log(1 + power/(1 + power*highest_order/2)))*life_of(line, 1.0_dp, max(n, 0.0_dp))
      end associate
    end do
  end function least_rise

  function drop_of(model, k, course_alone) result(drop)
    !! The drop of line k, or of its last course, with overlapping lines refitted.
    type(model_type), intent(in) :: model
    integer, intent(in) :: k
    logical, intent(in) :: course_alone
    type(drop_type) :: drop
    logical :: own(size(model%lines)), others(size(model%lines))
    type(line_type), allocatable :: lines(:)
    type(refit_type) :: found
    own = near(model, model%lines(k)%pole)
    own(k) = .true.
    others = own
    others(k) = course_alone
    lines = model%lines
    if (course_alone) lines(k)%courses = lines(k)%courses(:size(lines(k)%courses) - 1)
    drop%old = pack(lines%pole, own)
    drop%lines = pack(lines, others)
    if (size(drop%lines) == 0) return
    call refit(model, own, drop%lines, trial_steps, found)
    drop%lines = found%lines
  end function drop_of

end module bw_line_drops
