module bw_free_flight
  !! The gap v_tip − y between tip and mass from a contact on, and when it closes again. Units of bw_course.
  use bw_body_state, only: body_state, state_at
  use bw_course, only: leaves_range
  use bw_double_double, only: accurate_sum, to_dd, operator(*)
  use bw_kinds, only: dp
  use bw_mode_set, only: mode_set
  use bw_monitor, only: monitor_type
  use bw_signal, only: signal_type
  implicit none (type, external)
  private
  public :: fly, gap_of

  real(dp), parameter, public :: grazing = 1.0e-9_dp      !! of V: an approach below it is no contact
  real(dp), parameter, public :: finest = 1.0e-13_dp      !! of the record: to this its times are found

contains

  pure type(signal_type) function gap_of(free, omega, state) result(gap)
    !! v_tip − y from a contact on: its modes, then the mass.
    class(mode_set), intent(in) :: free
    real(dp), intent(in) :: omega
    type(body_state), intent(in) :: state
    gap%beta_squared = [free%beta_squared, to_dd(omega)*(-omega)]
    gap%u = [free%tip*state%q, -state%place]
    gap%u_dot = [free%tip*state%rate, -state%speed]
    gap%c = 0.0_dp*gap%u
    if (allocated(free%damping)) gap%c(:free%count) = free%damping
  end function gap_of

  subroutine fly(free, omega, longest, opening, state, found, out_of_range, monitor)
    !! Free motion to the next contact.
    class(mode_set), intent(in) :: free
    real(dp), intent(in) :: omega, longest
    integer, intent(in) :: opening                !! the first derivative of the gap that is not zero
    type(body_state), intent(inout) :: state
    logical, intent(out) :: found
    logical, intent(out) :: out_of_range
    class(monitor_type), intent(inout), optional :: monitor   !! nothing is found where it asks to stop
    type(signal_type) :: gap
    type(body_state) :: arrived
    real(dp) :: left, time, start, passing
    integer :: order
    left = longest - state%time%hi
    out_of_range = leaves_range(free, to_dd(left)) .or. omega*left > 300.0_dp
    found = .false.
    if (out_of_range) return
    gap = gap_of(free, omega, state)
    order = opening
    call settle(gap, order)
    start = 0.0_dp
    passing = 1.0e3_dp*finest*longest
    do
      if (start == 0.0_dp .and. order <= 3) then
        call gap%first_zero(start, left, finest*longest, found, time, order, monitor)
      else
        call gap%first_zero(max(start, passing), left, finest*longest, found, time, monitor=monitor)
      end if
      if (.not. found) return
      arrived = state_at(free, omega, state, time)
      if (is_contact(free, omega, arrived)) exit
      start = time + passing                        ! a graze: look for the next one from where the gap has opened
      passing = 2.0_dp*passing
    end do
    state = arrived
  end subroutine fly

  subroutine settle(gap, order)
    !! At the start of a flight the gap is exactly zero, and so are those of its derivatives that the contact has made
    !! so: take their roundings off. The first that is positive opens the gap; 4 where none is.
    type(signal_type), intent(inout) :: gap
    integer, intent(inout) :: order
    integer :: mass
    mass = size(gap%u)
    gap%u(mass) = -accurate_sum(gap%u(:mass - 1))
    if (order == 1 .and. gap%derivative(1) > grazing) return
    gap%u_dot(mass) = -accurate_sum(gap%u_dot(:mass - 1))
    order = max(order, 2)
    do while (order <= 3)
      if (gap%derivative(order) > 0.0_dp) return
      order = order + 1
    end do
  end subroutine settle

  logical function is_contact(free, omega, state)
    !! The mass approaches the tip, or is pressed against it, where the gap has closed.
    class(mode_set), intent(in) :: free
    real(dp), intent(in) :: omega
    type(body_state), intent(in) :: state
    type(signal_type) :: gap
    gap = gap_of(free, omega, state)
    is_contact = -gap%derivative(1) >= grazing .or. gap%derivative(2) < 0.0_dp
  end function is_contact

end module bw_free_flight
