module bw_contact_list
  !! The contacts of a motion and its courses between them, one after the other.
  use bw_course, only: course_type
  use bw_event, only: event_type
  use bw_kinds, only: dp
  implicit none (type, external)
  private

  type, public :: contact_list
    type(event_type), allocatable :: events(:)
    type(course_type), allocatable :: courses(:)
    integer :: event_count = 0, course_count = 0  !! of those that are there; there is room for more until `trim_to_size`
  contains
    procedure :: add_event
    procedure :: add_course
    procedure :: trim_to_size
  end type contact_list

  integer, parameter :: first_room = 8

contains

  subroutine add_event(self, event)
    !! One more.
    class(contact_list), intent(inout) :: self
    type(event_type), intent(in) :: event
    if (.not. allocated(self%events)) allocate (self%events(first_room))
    if (self%event_count == size(self%events)) call resize_events(self, 2*self%event_count)
    self%event_count = self%event_count + 1
    self%events(self%event_count) = event
  end subroutine add_event

  subroutine add_course(self, course)
    !! One more.
    class(contact_list), intent(inout) :: self
    type(course_type), intent(in) :: course
    if (.not. allocated(self%courses)) allocate (self%courses(first_room))
    if (self%course_count == size(self%courses)) call resize_courses(self, 2*self%course_count)
    self%course_count = self%course_count + 1
    self%courses(self%course_count) = course
  end subroutine add_course

  subroutine trim_to_size(self)
    !! Leaves room for no more.
    class(contact_list), intent(inout) :: self
    call resize_events(self, self%event_count)
    call resize_courses(self, self%course_count)
  end subroutine trim_to_size

  subroutine resize_events(self, room)
    type(contact_list), intent(inout) :: self
    integer, intent(in) :: room
    type(event_type), allocatable :: events(:)
    allocate (events(room))
    if (allocated(self%events)) events(:self%event_count) = self%events(:self%event_count)
    call move_alloc(events, self%events)
  end subroutine resize_events

  subroutine resize_courses(self, room)
    !! Their arrays are handed on, not copied.
    type(contact_list), intent(inout) :: self
    integer, intent(in) :: room
    type(course_type), allocatable :: courses(:)
    integer :: i
    allocate (courses(room))
    do i = 1, self%course_count
      courses(i)%modes = self%courses(i)%modes
      courses(i)%start = self%courses(i)%start
      courses(i)%start_error = self%courses(i)%start_error
      call move_alloc(self%courses(i)%q, courses(i)%q)
      call move_alloc(self%courses(i)%rate, courses(i)%rate)
      call move_alloc(self%courses(i)%error, courses(i)%error)
    end do
    call move_alloc(courses, self%courses)
  end subroutine resize_courses

end module bw_contact_list
