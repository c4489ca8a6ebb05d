module bw_cost
  !! J, which the search minimises: −2 ln L of the prediction errors plus the penalty of each unknown, such that noise alone yields
  !! a line with the probability `false_alarm`.
  use bw_kinds, only: dp
  use bw_model, only: model_type
  use bw_penalty, only: chi_squared, line_penalty
  use bw_samples, only: first_valid, samples_type
  implicit none (type, external)
  private
  public :: akaike, cost_beside_noise, cost_of_all, order_price, penalty_of_course, penalty_of_line, penalty_of_place, &
    & penalty_of_tone

  real(dp), parameter :: akaike = 2              !! the penalty of a coefficient of the noise if lines and noise alone are compared

contains

  pure real(dp) function cost_beside_noise(samples, false_alarm, model) result(cost)
    !! J of a model as it is compared with that of noise alone. There each coefficient of the noise costs 2 (Akaike, 1974): a driven
    !! motion has poles and zeros, and its autoregression no true order, so that a higher penalty would favour lines.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    type(model_type), intent(in) :: model
    integer :: coefficients
    coefficients = sum(model%noise%order)
    if (allocated(model%noise%mixing)) coefficients = coefficients + size(samples%value, 2)*(size(samples%value, 2) - 1)/2
    cost = cost_of_all(samples, false_alarm, model) - (order_price(samples) - akaike)*coefficients
  end function cost_beside_noise

  pure real(dp) function cost_of_all(samples, false_alarm, model) result(cost)
    !! J of a model.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    type(model_type), intent(in) :: model
    integer :: k
    cost = model%noise%cost + size(model%lines)*penalty_of_line(samples, false_alarm, model) &
      & + sum([(size(model%lines(k)%courses), k=1, size(model%lines))])*penalty_of_course(false_alarm) &
      & + count(model%lines%steady)*penalty_of_tone(samples, false_alarm) &
      & + count(model%stretches(1, 1:) > first_valid(samples))*penalty_of_place(samples, false_alarm)
  end function cost_of_all

  pure real(dp) function order_price(samples)
    !! The penalty of a coefficient of the noise's autoregression (Schwarz, 1978).
    type(samples_type), intent(in) :: samples
    order_price = log(real(samples%count, dp))
  end function order_price

  pure real(dp) function penalty_of_line(samples, false_alarm, model)
    !! The penalty of a line with its amplitudes at all sensors after all blows.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    type(model_type), intent(in) :: model
    penalty_of_line = line_penalty(false_alarm, samples%count, 2*size(samples%value, 2)*ubound(model%stretches, 2))
  end function penalty_of_line

  pure real(dp) function penalty_of_place(samples, false_alarm)
    !! The penalty of the place of a blow, but for one at the first valid sample: a record may begin within a decay.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    penalty_of_place = chi_squared(false_alarm/samples%count, 2)
  end function penalty_of_place

  pure real(dp) function penalty_of_course(false_alarm)
    !! The penalty of a drift's three unknowns, and of the choice among a few initial rates.
    real(dp), intent(in) :: false_alarm
    penalty_of_course = chi_squared(false_alarm, 4)
  end function penalty_of_course

  pure real(dp) function penalty_of_tone(samples, false_alarm)
    !! The penalty of a tone instead of a mode: one more amplitude at each sensor, before the blow, and no decay.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    penalty_of_tone = chi_squared(false_alarm, 2*size(samples%value, 2)) - chi_squared(false_alarm, 2)
  end function penalty_of_tone

end module bw_cost
