module bw_study_file
  !! The result of a study (what accuracy costs, what effects change): one NetCDF-4 file whose variables are defined and
  !! written one after another.
  use bw_kinds, only: dp
  use bw_error, only: error_type
  use bw_netcdf, only: netcdf_file, variable_text
  use bw_result_header, only: put_global_attributes, put_inputs
  use bw_scene, only: scene_type
  use bw_text, only: joined
  use netcdf, only: nf90_inquire_dimension, nf90_put_var
  implicit none (type, external)
  private
  public :: create_study

  type, extends(netcdf_file), public :: study_file
  contains
    procedure :: put_axis
    procedure :: put_numbers
    procedure :: put_counts
    procedure :: put_flags
    procedure :: finish
    procedure, private :: dimension_lengths
  end type study_file

  type, abstract, public :: study_values
    !! What a study has found.
  contains
    procedure(put_interface), deferred :: put
  end type study_values

  abstract interface
    subroutine put_interface(self, file, error)
      !! Puts all that was found into the file of the study.
      import :: error_type, study_file, study_values
      implicit none (type, external)
      class(study_values), intent(in) :: self
      type(study_file), intent(in) :: file
      type(error_type), allocatable, intent(inout) :: error
    end subroutine put_interface
  end interface

contains

  subroutine create_study(path, scene, study, file, error)
    !! Create a file with its global attributes and the scene's inputs.
    character(*), intent(in) :: path
    type(scene_type), intent(in) :: scene           !! without sweeps
    character(*), intent(in) :: study               !! the command that makes it
    type(study_file), intent(out) :: file
    type(error_type), allocatable, intent(out) :: error
    call file%create(path, error)
    if (allocated(error)) return
    call put_global_attributes(file, scene, error, study)
    if (allocated(scene%beam%pieces)) call file%put_axis('piece', size(scene%beam%pieces), 'piece, from the root', error)
    if (allocated(scene%bodies)) call file%put_axis('body', size(scene%bodies), 'body, in the order of the scene', error)
    call put_inputs(file, scene, error)
    call file%put_known(error)
  end subroutine create_study

  subroutine put_axis(self, name, length, long_name, error, words)
    !! Put a dimension, and its coordinate that counts from 1.
    class(study_file), intent(in) :: self
    character(*), intent(in) :: name, long_name
    integer, intent(in) :: length
    type(error_type), allocatable, intent(inout) :: error
    character(*), intent(in), optional :: words(:)  !! CF's flags: what each number means, (length)
    type(variable_text) :: text
    integer :: variable, i
    text = variable_text(name, name, '1', long_name, is_integer=.true., first_flag=1)
    if (present(words)) text%flags = joined(words)
    call self%add_dimension(name, length, error)
    call self%define(text, variable, error)
    if (.not. allocated(error)) call self%check(nf90_put_var(self%id, variable, [(i, i=1, length)]), error)
  end subroutine put_axis

  subroutine put_numbers(self, name, dimensions, units, long_name, values, error)
    !! Put a variable of real numbers.
    class(study_file), intent(in) :: self
    character(*), intent(in) :: name
    character(*), intent(in) :: dimensions          !! names in the file's order, by spaces; a scalar has none
    character(*), intent(in) :: units, long_name
    real(dp), intent(in) :: values(:)               !! the last dimension fastest; `missing` is fill
    type(error_type), allocatable, intent(inout) :: error
    integer :: variable
    call self%define(variable_text(name, dimensions, units, long_name), variable, error)
    if (allocated(error)) return
    call self%check(nf90_put_var(self%id, variable, values, count=self%dimension_lengths(dimensions)), error)
  end subroutine put_numbers

  subroutine put_counts(self, name, dimensions, long_name, values, error)
    !! Put a variable of integers, all of which exist.
    class(study_file), intent(in) :: self
    character(*), intent(in) :: name, dimensions, long_name
    integer, intent(in) :: values(:)
    type(error_type), allocatable, intent(inout) :: error
    call put_integers(self, variable_text(name, dimensions, '1', long_name, is_integer=.true.), values, error)
  end subroutine put_counts

  subroutine put_flags(self, name, dimensions, long_name, values, words, error)
    !! Put a variable of integers that stand for words, from 1.
    class(study_file), intent(in) :: self
    character(*), intent(in) :: name, dimensions, long_name
    integer, intent(in) :: values(:)
    character(*), intent(in) :: words(:)
    type(error_type), allocatable, intent(inout) :: error
    call put_integers(self, variable_text(name, dimensions, '1', long_name, is_integer=.true., flags=joined(words), &
                                          first_flag=1), values, error)
  end subroutine put_flags

  subroutine finish(self, notes, report, error)
    !! Put the notes and the tables, and close the file.
    class(study_file), intent(inout) :: self
    character(*), intent(in) :: notes               !! lines
    character(*), intent(in) :: report              !! what is printed of the numbers
    type(error_type), allocatable, intent(inout) :: error
    call self%put_text('notes', notes, error)
    call self%put_text('report', report, error)
    call self%close(error)
  end subroutine finish

  subroutine put_integers(self, text, values, error)
    !! Define a variable of integers and put its values.
    class(study_file), intent(in) :: self
    type(variable_text), intent(in) :: text
    integer, intent(in) :: values(:)                !! the last dimension fastest
    type(error_type), allocatable, intent(inout) :: error
    integer :: variable
    call self%define(text, variable, error)
    if (allocated(error)) return
    call self%check(nf90_put_var(self%id, variable, values, count=self%dimension_lengths(trim(text%dimensions))), error)
  end subroutine put_integers

  function dimension_lengths(self, names) result(lengths)
    !! The lengths of dimensions, as NetCDF wants them for the values of a variable, fastest first; one number for a scalar.
    class(study_file), intent(in) :: self
    character(*), intent(in) :: names               !! in the file's order, by spaces
    integer, allocatable :: lengths(:)
    integer :: i, ignored
    associate (ids => self%dimension_ids(names))
      allocate (lengths(max(1, size(ids))), source=1)
      do i = 1, size(ids)
        ignored = nf90_inquire_dimension(self%id, ids(i), len=lengths(i))
      end do
    end associate
  end function dimension_lengths

end module bw_study_file
