module patient_monitors
  !! A monitor that counts how often it is asked.
  use bw_kinds, only: dp
  use bw_monitor, only: monitor_type
  implicit none (type, external)
  private

  type, extends(monitor_type), public :: patient_monitor
    !! Says stop when it has been asked more often than it likes, and from then on.
    integer :: likes = huge(1)
    integer :: asked = 0
    real(dp) :: fraction = 0.0_dp
    logical :: goes_back = .false.     !! something done was taken back
  contains
    procedure :: advance
    procedure :: stop_requested
  end type patient_monitor

contains

  subroutine advance(self, fraction)
    class(patient_monitor), intent(inout) :: self
    real(dp), intent(in) :: fraction
    real(dp), parameter :: rounding = 1.0e-12_dp
    self%goes_back = self%goes_back .or. fraction < self%fraction - rounding .or. fraction > 1.0_dp + rounding
    self%fraction = fraction
  end subroutine advance

  logical function stop_requested(self)
    class(patient_monitor), intent(inout) :: self
    self%asked = self%asked + 1
    stop_requested = self%asked > self%likes
  end function stop_requested

end module patient_monitors
