module bw_blow_trials
  !! Blows are added, moved and dropped for a trial, and stay so if J falls after a refit of the lines.
  use bw_blow_moves, only: add_missing_blows, drop_blows, drop_gradual_blows, move_blows
  use bw_blow_shift, only: near
  use bw_cost, only: order_price
  use bw_kinds, only: dp
  use bw_line_drops, only: energy_of
  use bw_model, only: model_type
  use bw_refit, only: most_together, refit, refit_type, trial_steps
  use bw_renewal, only: renew
  use bw_samples, only: samples_type
  use bw_search_state, only: keep_if_cheaper, refit_in_new_noise, state_of, state_type
  implicit none (type, external)
  private
  public :: try_missing_blows, try_moved_blows

  integer, parameter :: most_moves = 4           !! of blows in a trial

contains

  subroutine try_missing_blows(samples, false_alarm, from, robust, model, added)
    !! Add missing blows. The poles have adapted to a motion without these, so that the lines are fitted again before a blow is
    !! moved, or dropped because the motion does not change suddenly. The strongest lines are fitted together in white noise first:
    !! in a short stretch all lines overlap, and coloured noise has no rows there.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    integer, intent(in) :: from                  !! first stretch to search; 0 is before any blow
    logical, intent(in) :: robust                !! the noise is not to absorb the motion after such blows
    type(model_type), intent(inout) :: model
    integer, intent(out) :: added
    integer, allocatable :: blows(:)
    real(dp) :: energy(size(model%lines))
    logical :: strong(size(model%lines))
    type(refit_type) :: found
    type(state_type) :: before
    integer :: dropped, moved, i, k
    added = 0
    if (allocated(samples%blow)) return
    before = state_of(samples, false_alarm, model)
    blows = model%stretches(1, 1:)
    call renew(samples, order_price(samples), robust, model)
    call add_missing_blows(samples, false_alarm, from, model, added)
    if (added == 0) return
    do i = 1, most_moves
      call renew(samples, order_price(samples), .false., model, 0)
      energy = [(energy_of(model, model%lines(k)), k=1, size(energy))]
      strong = [(count(energy > energy(k)) < most_together, k=1, size(energy))]
      call refit(model, strong, pack(model%lines, strong), trial_steps, found)
      model%lines = [pack(model%lines, .not. strong), found%lines]
      call renew(samples, order_price(samples), .false., model, 0)
      call drop_blows(samples, false_alarm, 0, 1.0_dp, model, dropped)
      call move_blows(samples, false_alarm, model, moved)
      if (dropped + moved == 0) exit
    end do
    call refit_in_new_noise(samples, model)
    call drop_gradual_blows(samples, false_alarm, blows, model)
    added = ubound(model%stretches, 2) - size(blows)
    call keep_if_cheaper(samples, false_alarm, before, model, added)
  end subroutine try_missing_blows

  subroutine try_moved_blows(samples, false_alarm, robust, model, changed)
    !! Drop blows that add no significant motion, and move others. Errors of poles, which are larger with more blows, may pass for
    !! motion, so that blows that gain several penalties are tried, too.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    logical, intent(in) :: robust                !! the noise is not to absorb lines that are still missing
    type(model_type), intent(inout) :: model
    integer, intent(out) :: changed              !! number of blows
    type(state_type) :: before
    real(dp), parameter :: penalties(2) = [1, 16]  !! tuned: so many bring J to the decision
    integer :: i, moved
    changed = 0
    if (allocated(samples%blow)) return
    before = state_of(samples, false_alarm, model)
    do i = 1, size(penalties)
      call renew(samples, order_price(samples), robust, model)
      call drop_blows(samples, false_alarm, near, penalties(i), model, changed)
      if (changed > 0) call keep_if_cheaper(samples, false_alarm, before, model, changed)
      if (changed > 0) exit
    end do
    if (changed > 0) before = state_of(samples, false_alarm, model)
    call renew(samples, order_price(samples), robust, model)
    call move_blows(samples, false_alarm, model, moved)
    if (moved > 0) call keep_if_cheaper(samples, false_alarm, before, model, moved)
    changed = changed + moved
  end subroutine try_moved_blows

end module bw_blow_trials
