module bw_event
  !! What is recorded of an instant at which the state jumps, and a list of such events with the segments of the motion
  !! between them.
  use bw_kinds, only: dp
  use bw_segment, only: segment_type
  implicit none (type, external)
  private

  integer, parameter, public :: no_event = 0, impact_event = 1, capture_event = 2, release_event = 3, contact_event = 4
  character(*), parameter, public :: event_words(0:*) = &
    [character(8) :: 'none', 'impact', 'capture', 'release', 'contact']   !! by number

  type, public :: event_type
    !! Masses in m_i, velocities in the approach velocity V; times in s.
    integer :: kind = impact_event
    real(dp) :: time = 0.0_dp                       !! s
    real(dp) :: end_time = 0.0_dp                   !! s, equal to `time` for an instant
    real(dp) :: time_error = 0.0_dp                 !! s, estimate of the error of `time`
    real(dp) :: end_error = 0.0_dp                  !! s, the same of `end_time`
    real(dp) :: impulse = 0.0_dp                    !! on the beam's tip, m_i V
    real(dp) :: energy_before = 0.0_dp              !! energy of beam and mass in the rotating frame, m_i V²
    real(dp) :: energy_after = 0.0_dp
    real(dp) :: momentum_before = 0.0_dp
      !! generalised momentum of the first mode of the set in force (of the beam alone at a release), per unit of its
      !! tip displacement, m_i V
    real(dp) :: momentum_after = 0.0_dp
  end type event_type

  type, public :: event_list
    type(event_type), allocatable :: events(:)
    type(segment_type), allocatable :: segments(:)
    integer :: event_count = 0, segment_count = 0  !! of those that are there; there is room for more until `trim_to_size`
  contains
    procedure :: add_event
    procedure :: add_segment
    procedure :: trim_to_size
  end type event_list

  integer, parameter :: first_room = 8

contains

  subroutine add_event(self, event)
    !! One more.
    class(event_list), intent(inout) :: self
    type(event_type), intent(in) :: event
    if (.not. allocated(self%events)) allocate (self%events(first_room))
    if (self%event_count == size(self%events)) call resize_events(self, 2*self%event_count)
    self%event_count = self%event_count + 1
    self%events(self%event_count) = event
  end subroutine add_event

  subroutine add_segment(self, segment)
    !! One more.
    class(event_list), intent(inout) :: self
    type(segment_type), intent(in) :: segment
    if (.not. allocated(self%segments)) allocate (self%segments(first_room))
    if (self%segment_count == size(self%segments)) call resize_segments(self, 2*self%segment_count)
    self%segment_count = self%segment_count + 1
    self%segments(self%segment_count) = segment
  end subroutine add_segment

  subroutine trim_to_size(self)
    !! Leaves room for no more.
    class(event_list), intent(inout) :: self
    call resize_events(self, self%event_count)
    call resize_segments(self, self%segment_count)
  end subroutine trim_to_size

  subroutine resize_events(self, room)
    type(event_list), intent(inout) :: self
    integer, intent(in) :: room
    type(event_type), allocatable :: events(:)
    allocate (events(room))
    if (allocated(self%events)) events(:self%event_count) = self%events(:self%event_count)
    call move_alloc(events, self%events)
  end subroutine resize_events

  subroutine resize_segments(self, room)
    !! Their arrays are handed on, not copied.
    type(event_list), intent(inout) :: self
    integer, intent(in) :: room
    type(segment_type), allocatable :: segments(:)
    integer :: i
    allocate (segments(room))
    do i = 1, self%segment_count
      segments(i)%modes = self%segments(i)%modes
      segments(i)%start = self%segments(i)%start
      segments(i)%start_error = self%segments(i)%start_error
      call move_alloc(self%segments(i)%q, segments(i)%q)
      call move_alloc(self%segments(i)%rate, segments(i)%rate)
      call move_alloc(self%segments(i)%error, segments(i)%error)
    end do
    call move_alloc(segments, self%segments)
  end subroutine resize_segments

end module bw_event
