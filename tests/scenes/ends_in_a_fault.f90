program ends_in_a_fault
  !! Under the program's guard over its process, do what only a fault in a program does: `ends_in_a_fault KIND`.
  use, intrinsic :: iso_c_binding, only: c_f_pointer, c_intptr_t, c_ptr
  use bw_kinds, only: dp, i8
  use bw_process, only: watch_over_process
  implicit none (type, external)
  character(20) :: kind

  call watch_over_process()
  call get_command_argument(1, kind)
  select case (kind)
  case ('run-time-error'); call read_a_word_as_a_number()
  case ('bad-allocation'); call allocate_without_asking(2_i8**57)
  case ('segfault'); call write_to_address(8_c_intptr_t)
  case ('full-stack'); print '(es9.2)', deeper(0.0_dp)
  case ('error-stop'); error stop 4
  case ('stop'); stop
  end select

contains

  subroutine read_a_word_as_a_number()
    character(4) :: word
    integer :: number
    word = 'word'
    read (word, '(i4)') number
    print '(i0)', number
  end subroutine read_a_word_as_a_number

  subroutine allocate_without_asking(length)
    integer(i8), intent(in) :: length
    real(dp), allocatable :: room(:)
    allocate (room(length))
    room = 0.0_dp
    print '(es9.2)', room(length)
  end subroutine allocate_without_asking

  subroutine write_to_address(address)
    integer(c_intptr_t), intent(in) :: address
    integer, pointer :: nothing
    type(c_ptr) :: place
    place = transfer(address, place)
    call c_f_pointer(place, nothing)
    nothing = 1
  end subroutine write_to_address

  recursive real(dp) function deeper(number) result(sum)
    real(dp), intent(in) :: number
    real(dp) :: more(1000)
    more = number + 1.0_dp
    sum = deeper(more(1)) + deeper(more(size(more)))
  end function deeper

end program ends_in_a_fault
