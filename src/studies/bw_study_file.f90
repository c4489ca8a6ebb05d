module bw_study_file
  !! The result of a study, such as `accuracy` or `effects`: one NetCDF file, written when all is known. `put` of a
  !! study is called twice: first to define the variables, then to store their values.
  use bw_error, only: error_type
  use bw_file_rows, only: input_rows
  use bw_files, only: remove_file
  use bw_kinds, only: dp, i8
  use bw_result_header, only: history_text, put_attributes, time_stamp
  use bw_result_table, only: before_cases, result_table
  use bw_scene, only: scene_type
  implicit none (type, external)
  private
  public :: write_study

  type, extends(result_table), public :: study_file
    logical, private :: is_laid_out = .false.
  contains
    procedure :: put_text
    procedure :: put_axis
    procedure :: put_numbers
    procedure :: put_counts
  end type study_file

  type, abstract, public :: study_values
    !! The findings of a study.
  contains
    procedure(put_interface), deferred :: put
  end type study_values

  abstract interface
    subroutine put_interface(self, file)
      !! Puts all findings into the file of the study.
      import :: study_file, study_values
      class(study_values), intent(in) :: self
      type(study_file), intent(inout) :: file
    end subroutine put_interface
  end interface

contains

  subroutine write_study(path, scene, study, values, notes, report, error)
    !! Write the whole file to the disk, in place of an unfinished one.
    !! **Errors**: it cannot be written.
    character(*), intent(in) :: path
    type(scene_type), intent(in) :: scene           !! without sweeps
    character(*), intent(in) :: study               !! the command
    class(study_values), intent(in) :: values
    character(*), intent(in) :: notes               !! lines
    character(*), intent(in) :: report              !! the printed report
    type(error_type), allocatable, intent(inout) :: error
    type(study_file) :: file
    character(:), allocatable :: head
    logical :: fits
    integer :: ignored
    call put_attributes(file%head, scene, study)
    call put_all()
    call file%lay_out(head, fits)
    file%is_laid_out = .true.
    ignored = remove_file(path)
    call file%file%make(path, file%head%bytes, file%head%bytes, error)
    if (.not. allocated(error)) then
      call file%file%put_text(0_i8, head)
      call put_all()
      call file%set_text('created', time_stamp())
      call file%set_text('history', history_text(scene, study))
      call file%set_text('notes', notes)
      call file%set_text('report', report)
      call file%file%flush(error)
    end if
    call file%file%close()
  contains
    subroutine put_all()
      file%swept = ''
      call file%begin_section(before_cases)
      if (allocated(scene%beam%pieces)) call file%put_axis('piece', size(scene%beam%pieces), 'piece, from the root')
      if (allocated(scene%beam%outer)) call file%put_axis('station', size(scene%beam%outer) + 1, 'station, from the root')
      if (allocated(scene%forces)) call file%put_axis('force', size(scene%forces), 'force, in the order of the scene')
      if (allocated(scene%bases)) call file%put_axis('base', size(scene%bases), 'motion of the base, in the order of the scene')
      if (allocated(scene%bodies)) call file%put_axis('body', size(scene%bodies), 'body, in the order of the scene')
      call input_rows(file, scene)
      call values%put(file)
    end subroutine put_all
  end subroutine write_study

  subroutine put_text(self, name, text)
    !! Put an attribute of the file.
    class(study_file), intent(inout) :: self
    character(*), intent(in) :: name, text
    if (.not. self%is_laid_out) call self%head%add_text(name, text, of_file=.true.)
  end subroutine put_text

  subroutine put_axis(self, name, length, long_name, words)
    !! Put a dimension, and its coordinate that counts from 1.
    class(study_file), intent(inout) :: self
    character(*), intent(in) :: name, long_name
    integer, intent(in) :: length
    character(*), intent(in), optional :: words(:)  !! CF flags: the meaning of each number, (length)
    integer :: i
    if (.not. self%is_laid_out) call self%head%add_dimension(name, length)
    call self%put_counts(name, name, long_name, [(i, i=1, length)], words)
  end subroutine put_axis

  subroutine put_numbers(self, name, dimensions, units, long_name, values)
    !! Put a variable of real numbers.
    class(study_file), intent(inout) :: self
    character(*), intent(in) :: name
    character(*), intent(in) :: dimensions          !! names in the file's order, separated by spaces; empty for a scalar
    character(*), intent(in) :: units, long_name
    real(dp), intent(in) :: values(:)               !! the last dimension fastest; `missing` is fill
    if (self%real_row(name, dimensions, units, long_name)) call self%put(values)
  end subroutine put_numbers

  subroutine put_counts(self, name, dimensions, long_name, values, words)
    !! Put a variable of integers, all of which exist.
    class(study_file), intent(inout) :: self
    character(*), intent(in) :: name, dimensions, long_name
    integer, intent(in) :: values(:)                !! the last dimension fastest
    character(*), intent(in), optional :: words(:)  !! the meaning of each value, from 1
    if (self%whole_row(name, dimensions, long_name, words, 1)) call self%put(values)
  end subroutine put_counts

end module bw_study_file
