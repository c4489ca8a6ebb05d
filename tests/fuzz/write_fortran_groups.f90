program write_fortran_groups
  !! Writes the module `fortran_groups`, in which each group of the table of names is a namelist of Fortran, read by the compiler's
  !! own library. Columns are left out: Fortran has no value that is a name or a number.
  use bw_input_name, only: columns_input, input_name, integer_input, logical_input, reals_input, text_input, texts_input
  use bw_input_table, only: group_table, name_table
  implicit none (type, external)
  integer :: g
  call put('module fortran_groups')
  call put('  use bw_kinds, only: dp')
  call put('  use bw_text, only: lower')
  call put('  use read_comparison, only: comparison, longest_text, most_texts, most_values, unset, unset_text, unset_whole')
  call put('  implicit none (type, external)')
  call put('contains')
  call put('  subroutine read_group(lines, name, both)')
  call put('    character(*), intent(in) :: lines(:), name')
  call put('    type(comparison), intent(inout) :: both')
  call put('    select case (name)')
  do g = 1, size(group_table)
    call put('    case ("'//trim(group_table(g)%name)//'"); call read_'//trim(group_table(g)%name)//'(lines, both)')
  end do
  call put('    end select')
  call put('  end subroutine')
  do g = 1, size(group_table)
    call write_group(trim(group_table(g)%name))
  end do
  call put('end module')

contains

  subroutine put(line)
    character(*), intent(in) :: line
    write (*, '(a)') line
  end subroutine put

  subroutine write_group(group)
    !! The namelist of a group, and what it reads beside what the scene holds.
    character(*), intent(in) :: group
    type(input_name), allocatable :: names(:)
    integer :: i
    names = pack(name_table, name_table%group == group .and. name_table%kind /= columns_input)
    call put('  subroutine read_'//group//'(lines, both)')
    call put('    character(*), intent(in) :: lines(:)')
    call put('    type(comparison), intent(inout) :: both')
    call put('    integer :: i')
    do i = 1, size(names)
      call put('    '//declared(names(i))//' :: '//trim(names(i)%name))
    end do
    call put('    namelist /'//group//'/ '//trim(names(1)%name))
    do i = 2, size(names)
      call put('    namelist /'//group//'/ '//trim(names(i)%name))
    end do
    do i = 1, size(names)
      call put('    '//trim(names(i)%name)//' = '//unset_value(names(i)))
    end do
    call put('    read (lines, nml='//group//', iostat=both%stat)')
    do i = 1, size(names)
      call put('    call both%'//compared(names(i), trim(names(i)%name)))
    end do
    call put('  end subroutine')
  end subroutine write_group

  pure function declared(row) result(text)
    type(input_name), intent(in) :: row
    character(:), allocatable :: text
    select case (row%kind)
    case (integer_input); text = 'integer'
    case (logical_input); text = 'logical'
    case (text_input); text = 'character(longest_text)'
    case (texts_input); text = 'character(longest_text), dimension(most_texts)'
    case (reals_input); text = 'real(dp), dimension(most_values)'
    case default; text = 'real(dp)'
    end select
  end function declared

  pure function unset_value(row) result(text)
    type(input_name), intent(in) :: row
    character(:), allocatable :: text
    select case (row%kind)
    case (integer_input); text = 'unset_whole'
    case (logical_input); text = trim(row%default)
    case (text_input, texts_input); text = 'unset_text'
    case default; text = 'unset'
    end select
  end function unset_value

  pure function compared(row, name) result(text)
    !! Words are accepted in any case.
    type(input_name), intent(in) :: row
    character(*), intent(in) :: name
    character(:), allocatable :: text
    select case (row%kind)
    case (integer_input); text = "same_whole('"//name//"', "//name//')'
    case (logical_input); text = "same_flag('"//name//"', "//name//')'
    case (text_input)
      text = "same_text('"//name//"', "//name//')'
      if (row%words /= '') text = "same_text('"//name//"', lower("//name//'))'
    case (texts_input)
      text = "same_texts('"//name//"', "//name//')'
      if (row%words /= '') text = "same_texts('"//name//"', [(lower("//name//'(i)), i=1, most_texts)])'
    case (reals_input); text = "same_list('"//name//"', "//name//')'
    case default; text = "same_real('"//name//"', "//name//')'
    end select
  end function compared

end program write_fortran_groups
