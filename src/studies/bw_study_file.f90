module bw_study_file
  !! The result of a study (what accuracy costs, what effects change): one NetCDF-4 file whose variables are defined and
  !! written one after another.
  use bw_kinds, only: dp
  use bw_error, only: error_type
  use bw_late_values, only: late_values
  use bw_netcdf, only: check, create_file, define_variable, put_words
  use bw_result_header, only: put_global_attributes, put_inputs
  use bw_scene, only: scene_type
  use netcdf, only: nf90_close, nf90_def_dim, nf90_double, nf90_global, nf90_inq_dimid, &
    nf90_inquire_dimension, nf90_int, nf90_put_att, nf90_put_var
  implicit none (type, external)
  private
  public :: create_study

  type, public :: study_file
    character(:), allocatable :: path
    integer, private :: id = 0                      !! NetCDF's
  contains
    procedure :: put_axis
    procedure :: put_text
    procedure :: put_numbers
    procedure :: put_counts
    procedure :: put_flags
    procedure :: finish
    procedure, private :: dimension_ids
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
    type(late_values) :: late
    file%path = path
    call create_file(path, file%id, error)
    if (allocated(error)) return
    call put_global_attributes(file%id, path, scene, error, study)
    call put_inputs(file%id, path, scene, late, error)
    call late%put_all(file%id, path, error)
  end subroutine create_study

  subroutine put_axis(self, name, length, long_name, error, words)
    !! Put a dimension, and its coordinate that counts from 1.
    class(study_file), intent(in) :: self
    character(*), intent(in) :: name, long_name
    integer, intent(in) :: length
    type(error_type), allocatable, intent(inout) :: error
    character(*), intent(in), optional :: words(:)  !! CF's flags: what each number means, (length)
    integer :: dimension, variable, i
    if (allocated(error)) return
    call check(nf90_def_dim(self%id, name, length, dimension), self%path, error)
    if (allocated(error)) return
    call define_variable(self%id, self%path, name, nf90_int, [dimension], '1', long_name, variable, error)
    if (present(words)) call put_words(self%id, self%path, variable, words, 1, error)
    if (allocated(error)) return
    call check(nf90_put_var(self%id, variable, [(i, i=1, length)]), self%path, error)
  end subroutine put_axis

  subroutine put_text(self, name, text, error)
    !! Put a global attribute.
    class(study_file), intent(in) :: self
    character(*), intent(in) :: name, text
    type(error_type), allocatable, intent(inout) :: error
    if (allocated(error)) return
    call check(nf90_put_att(self%id, nf90_global, name, text), self%path, error)
  end subroutine put_text

  subroutine put_numbers(self, name, dimensions, units, long_name, values, error)
    !! Put a variable of real numbers.
    class(study_file), intent(in) :: self
    character(*), intent(in) :: name
    character(*), intent(in) :: dimensions          !! names in the file's order, by spaces; a scalar has none
    character(*), intent(in) :: units, long_name
    real(dp), intent(in) :: values(:)               !! the last dimension fastest; `missing` is fill
    type(error_type), allocatable, intent(inout) :: error
    integer, allocatable :: ids(:)
    integer :: variable
    if (allocated(error)) return
    ids = self%dimension_ids(dimensions)
    call define_variable(self%id, self%path, name, nf90_double, ids, units, long_name, variable, error)
    if (allocated(error)) return
    call check(nf90_put_var(self%id, variable, values, count=self%dimension_lengths(ids)), self%path, error)
  end subroutine put_numbers

  subroutine put_counts(self, name, dimensions, long_name, values, error)
    !! Put a variable of integers, all of which exist.
    class(study_file), intent(in) :: self
    character(*), intent(in) :: name, dimensions, long_name
    integer, intent(in) :: values(:)
    type(error_type), allocatable, intent(inout) :: error
    integer :: variable
    call put_integers(self, name, dimensions, long_name, values, variable, error)
  end subroutine put_counts

  subroutine put_flags(self, name, dimensions, long_name, values, words, error)
    !! Put a variable of integers that stand for words, from 1.
    class(study_file), intent(in) :: self
    character(*), intent(in) :: name, dimensions, long_name
    integer, intent(in) :: values(:)
    character(*), intent(in) :: words(:)
    type(error_type), allocatable, intent(inout) :: error
    integer :: variable
    call put_integers(self, name, dimensions, long_name, values, variable, error)
    if (.not. allocated(error)) call put_words(self%id, self%path, variable, words, 1, error)
  end subroutine put_flags

  subroutine finish(self, notes, error)
    !! Put the notes, and close the file.
    class(study_file), intent(inout) :: self
    character(*), intent(in) :: notes               !! what the report warned of, lines
    type(error_type), allocatable, intent(inout) :: error
    call self%put_text('notes', notes, error)
    if (.not. allocated(error)) call check(nf90_close(self%id), self%path, error)
  end subroutine finish

  subroutine put_integers(self, name, dimensions, long_name, values, variable, error)
    !! Define a variable of integers and put its values.
    class(study_file), intent(in) :: self
    character(*), intent(in) :: name, dimensions, long_name
    integer, intent(in) :: values(:)
    integer, intent(out) :: variable
    type(error_type), allocatable, intent(inout) :: error
    integer, allocatable :: ids(:)
    if (allocated(error)) return
    ids = self%dimension_ids(dimensions)
    call define_variable(self%id, self%path, name, nf90_int, ids, '1', long_name, variable, error)
    if (allocated(error)) return
    call check(nf90_put_var(self%id, variable, values, count=self%dimension_lengths(ids)), self%path, error)
  end subroutine put_integers

  function dimension_ids(self, names) result(ids)
    !! NetCDF's numbers of dimensions, fastest first.
    class(study_file), intent(in) :: self
    character(*), intent(in) :: names               !! in the file's order, by spaces
    integer, allocatable :: ids(:)
    integer :: first, gap, id, status
    allocate (ids(0))
    first = 1
    do while (first <= len(names))
      gap = index(names(first:)//' ', ' ')
      status = nf90_inq_dimid(self%id, names(first:first + gap - 2), id)
      ids = [id, ids]
      first = first + gap
    end do
  end function dimension_ids

  function dimension_lengths(self, ids) result(lengths)
    !! The lengths of dimensions, as NetCDF wants them for the values of a variable; one number for a scalar.
    class(study_file), intent(in) :: self
    integer, intent(in) :: ids(:)
    integer, allocatable :: lengths(:)
    integer :: i, status
    allocate (lengths(max(1, size(ids))), source=1)
    do i = 1, size(ids)
      status = nf90_inquire_dimension(self%id, ids(i), len=lengths(i))
    end do
  end function dimension_lengths

end module bw_study_file
