module bw_load_report
  !! The printed report of applied loads.
  use bw_case_result, only: case_result
  use bw_scene, only: scene_type
  use bw_text, only: replaced, shortest, text_builder, text_of
  implicit none (type, external)
  private
  public :: report_loads

  integer, parameter :: shown_loads = 10

contains

  subroutine report_loads(scene, result, lines)
    !! Print a line for each load.
    type(scene_type), intent(in) :: scene
    type(case_result), intent(in) :: result
    type(text_builder), intent(inout) :: lines
    integer :: l
    call lines%append_line('')
    if (allocated(scene%forces)) then
      do l = 1, min(shown_loads, size(scene%forces))
        call lines%append_line('  Force '//text_of(l)//' at xi = '//shortest(scene%forces(l)%position, 4)//': '// &
          in_words(scene%forces(l)%shape)//', up to '//shortest(result%loads%applied_force(l), 6)//' N; impulse '// &
          shortest(result%loads%applied_impulse(l), 6)//' N s')
      end do
      if (size(scene%forces) > shown_loads) call lines%append_line('  ... '//text_of(size(scene%forces))//' in the file')
    end if
    if (allocated(scene%bases)) then
      do l = 1, min(shown_loads, size(scene%bases))
        call lines%append_line('  Acceleration '//text_of(l)//' of the base: '//in_words(scene%bases(l)%shape)//', up to '// &
          shortest(result%loads%applied_acceleration(l), 6)//' m/s2; the base gains '// &
          shortest(result%loads%applied_velocity(l), 6)//' m/s')
      end do
      if (size(scene%bases) > shown_loads) call lines%append_line('  ... '//text_of(size(scene%bases))//' in the file')
    end if
  end subroutine report_loads

  pure function in_words(shape) result(words)
    !! Return the name of a shape in words: `half sine`.
    character(*), intent(in) :: shape
    character(:), allocatable :: words
    words = replaced(shape, '_', ' ')
    if (words == 'file') words = 'measured'
  end function in_words

end module bw_load_report
