module bw_search_state
  !! States of a model, to which the search returns if moves have not lowered J.
  use bw_autoregression, only: autoregression
  use bw_cost, only: cost_beside_noise, cost_of_all, order_price
  use bw_kinds, only: dp
  use bw_line, only: line_type
  use bw_model, only: model_type
  use bw_refit, only: negligible_gain, refit_all, trial_steps
  use bw_renewal, only: renew
  use bw_samples, only: samples_type
  implicit none (type, external)
  private
  public :: go_back, keep_best, keep_if_cheaper, refit_in_new_noise, state_of

  type, public :: state_type
    !! The state of a model, to which the search may return.
    type(line_type), allocatable :: lines(:)
    integer, allocatable :: stretches(:, :)      !! (2, 0:B)
    real(dp), allocatable :: trend(:, :, :)      !! (2, S, 0:B)
    type(autoregression), allocatable :: start(:)  !! noise of each sensor, if samples are missing: its estimate has several minima
    real(dp) :: cost = huge(1.0_dp)              !! J
    real(dp) :: beside_noise = huge(1.0_dp)      !! J as it is compared with that of noise alone
  end type state_type

contains

  function state_of(samples, false_alarm, model) result(state)
    !! The state of a model, with J.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    type(model_type), intent(inout) :: model     !! renewed
    type(state_type) :: state
    call renew(samples, order_price(samples), .false., model)
    state%cost = cost_of_all(samples, false_alarm, model)
    state%beside_noise = cost_beside_noise(samples, false_alarm, model)
    if (allocated(model%start)) state%start = model%start
    allocate (state%lines, source=model%lines)
    allocate (state%stretches(2, 0:ubound(model%stretches, 2)), source=model%stretches)
    allocate (state%trend(2, size(model%trend, 2), 0:ubound(model%stretches, 2)), source=model%trend)
  end function state_of

  subroutine keep_if_cheaper(samples, false_alarm, before, model, moved)
    !! Refit the lines of a model, and return to the state before if that has the lower J.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    type(state_type), intent(inout) :: before
    type(model_type), intent(inout) :: model
    integer, intent(inout) :: moved              !! number of changes; 0 if the model returns
    call refit_in_new_noise(samples, model)
    if (cost_of_all(samples, false_alarm, model) < before%cost) return
    moved = 0
    call go_back(samples, before, model)
  end subroutine keep_if_cheaper

  subroutine refit_in_new_noise(samples, model)
    !! Refit all lines with the noise renewed before and after.
    type(samples_type), intent(in) :: samples
    type(model_type), intent(inout) :: model
    call renew(samples, order_price(samples), .false., model)
    call refit_all(trial_steps, negligible_gain, model)
    call renew(samples, order_price(samples), .false., model)
  end subroutine refit_in_new_noise

  subroutine keep_best(samples, false_alarm, model, best)
    !! Keep the state of least J.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    type(model_type), intent(inout) :: model     !! is renewed
    type(state_type), intent(inout) :: best
    call renew(samples, order_price(samples), .false., model)
    if (cost_of_all(samples, false_alarm, model) < best%cost) best = state_of(samples, false_alarm, model)
  end subroutine keep_best

  subroutine go_back(samples, before, model)
    !! Return a model to a state that it had before.
    type(samples_type), intent(in) :: samples
    type(state_type), intent(in) :: before
    type(model_type), intent(inout) :: model
    if (allocated(before%start)) model%start = before%start
    deallocate (model%lines, model%stretches, model%trend)
    allocate (model%lines, source=before%lines)
    allocate (model%stretches(2, 0:ubound(before%stretches, 2)), source=before%stretches)
    allocate (model%trend(2, size(before%trend, 2), 0:ubound(before%stretches, 2)), source=before%trend)
    call renew(samples, order_price(samples), .false., model)
  end subroutine go_back

end module bw_search_state
