module bw_result_file
  !! The result of a scene: one NetCDF-4 file. Every number of every case is written once, those of a sweep by
  !! blocks of cases. After a failure the file is not touched any more, as HDF5 does not bear that: who writes
  !! it does so in a process of its own.
  use bw_kinds, only: dp, i4, i8
  use bw_case_fields, only: case_block, case_field, fields_of, put_field, variables_of
  use bw_case_result, only: case_result
  use bw_error, only: error_type
  use bw_netcdf, only: netcdf_file, variable_text
  use bw_result_header, only: coordinates_of, put_coordinates, put_global_attributes, put_inputs, swept_names
  use bw_result_layout, only: dimension_length, dimension_names, has, result_layout
  use bw_result_variable, only: result_variable
  use bw_scene, only: scene_type
  use bw_scene_resolved, only: numeric_input, numeric_inputs
  use netcdf, only: nf90_inq_varid, nf90_nofill, nf90_put_var, nf90_set_fill
  implicit none (type, external)
  private
  public :: create_result, result_bytes

  type, extends(netcdf_file), public :: result_file
    type(case_field), allocatable, private :: fields(:)   !! what depends on the case
    integer, allocatable, private :: variables(:)         !! NetCDF's numbers of them
    integer, private :: seconds = 0                       !! NetCDF's number of `stage_seconds`
  contains
    procedure :: put_case
    procedure :: put_cases
    procedure :: finish
  end type result_file

contains

  subroutine create_result(path, scene, layout, file, error)
    !! A new file with all its dimensions, variables, coordinates and inputs, and no case. **Errors**: `status_bad_file`.
    character(*), intent(in) :: path
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    type(result_file), intent(out) :: file
    type(error_type), allocatable, intent(out) :: error
    integer :: former, seconds, i
    file%fields = fields_of(layout)
    call file%create(path, error)
    if (allocated(error)) return
    call file%check(nf90_set_fill(file%id, nf90_nofill, former), error)    ! no array is written twice
    call put_global_attributes(file, scene, error)
    if (allocated(layout%record)) call file%put_text('record_checksum', layout%record%checksums, error)
    do i = 1, size(dimension_names)
      associate (length => dimension_length(layout, trim(dimension_names(i))))
        if (length > 0) call file%add_dimension(trim(dimension_names(i)), length, error)
      end associate
    end do
    call define_variables(file, layout, swept_names(scene), error)
    call file%define(variable_text('stage_seconds', 'stage', 's', 'wall time of the stage over all cases'), seconds, error)
    file%seconds = seconds
    call put_coordinates(file, scene, layout, error)
    call put_inputs(file, scene, error)
    call file%put_known(error)
    call find_variables(file, error)
  end subroutine create_result

  subroutine define_variables(file, layout, swept, error)
    !! Everything that depends on the case, with `case` leading in a sweep.
    type(result_file), intent(in) :: file
    type(result_layout), intent(in) :: layout
    character(*), intent(in) :: swept                     !! variables of swept inputs, by spaces
    type(error_type), allocatable, intent(inout) :: error
    type(variable_text) :: text
    character(:), allocatable :: coordinates
    type(result_variable), allocatable :: rows(:)
    integer :: i, variable
    rows = variables_of(layout)
    do i = 1, size(rows)
      text = rows(i)%variable_text
      coordinates = trim(adjustl(swept//position_of(text%dimensions, has(layout, 'places'))))
      if (layout%cases > 0) text%dimensions = 'case '//trim(text%dimensions)
      call file%define(text, variable, error)
      if (coordinates /= '') call file%put_text('coordinates', coordinates, error, variable)
    end do
  end subroutine define_variables

  pure function position_of(dimensions, placed) result(name)
    !! The places along the beam that belong to a variable's dimensions, behind a space.
    character(*), intent(in) :: dimensions
    logical, intent(in) :: placed                         !! points have places
    character(:), allocatable :: name
    name = ''
    if (index(dimensions, 'point') == 1 .and. placed) name = ' point_position'
    if (index(' '//dimensions, ' profile') > 0) name = ' profile_position'
  end function position_of

  subroutine find_variables(file, error)
    !! Ask for NetCDF's numbers of the fields, once.
    type(result_file), intent(inout) :: file
    type(error_type), allocatable, intent(inout) :: error
    integer :: i
    if (allocated(error)) return
    allocate (file%variables(size(file%fields)))
    do i = 1, size(file%fields)
      call file%check(nf90_inq_varid(file%id, trim(file%fields(i)%name), file%variables(i)), error)
    end do
  end subroutine find_variables

  pure integer(i8) function result_bytes(scene, layout) result(bytes)
    !! How large the result of a scene will be: its numbers, and what is said of them.
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    integer, parameter :: head_bytes = 8000      !! of the file's own attributes; measured
    integer, parameter :: text_bytes = 700       !! of a variable's name and attributes; measured
    type(case_field), allocatable :: fields(:)
    type(variable_text), allocatable :: coordinates(:)
    type(numeric_input), allocatable :: inputs(:)
    integer(i8) :: cases
    integer :: i
    fields = fields_of(layout)
    coordinates = coordinates_of(layout)
    inputs = numeric_inputs(scene)
    cases = max(1, layout%cases)
    bytes = cases*sum(number_bytes(fields%is_integer)*fields%length) &
      + text_bytes*(size(fields) + size(coordinates) + size(inputs)) + head_bytes
    do i = 1, size(coordinates)
      bytes = bytes + number_bytes(coordinates(i)%is_integer)*dimension_length(layout, trim(coordinates(i)%dimensions))
    end do
    do i = 1, size(inputs)
      bytes = bytes + number_bytes(inputs(i)%is_integer)*merge(cases, 1_i8, inputs(i)%is_swept)*size(inputs(i)%values)
      if (inputs(i)%dimension /= '') bytes = bytes + (8*cases + text_bytes)*count(inputs(i)%sweeps > 0)
    end do
  end function result_bytes

  elemental integer(i8) function number_bytes(is_integer) result(bytes)
    !! How many bytes a number takes in the file.
    logical, intent(in) :: is_integer
    bytes = merge(4_i8, 8_i8, is_integer)
  end function number_bytes

  subroutine put_case(self, result, error)
    !! The only case of a scene without sweeps, a variable at a time.
    class(result_file), intent(in) :: self
    type(case_result), intent(in) :: result
    type(error_type), allocatable, intent(out) :: error
    real(dp), allocatable :: numbers(:)
    integer :: i
    do i = 1, size(self%fields)
      allocate (numbers(self%fields(i)%length))
      call put_field(result, self%fields(i), numbers)
      call put_variable(self, i, 1_i8, 1, numbers, error)
      deallocate (numbers)
    end do
  end subroutine put_case

  subroutine put_cases(self, block, error)
    !! Consecutive cases of a sweep, those fields of them that the block holds; it is empty then.
    class(result_file), intent(in) :: self
    type(case_block), intent(inout) :: block
    type(error_type), allocatable, intent(inout) :: error
    integer :: i
    if (block%count == 0) return
    do i = 1, size(block%fields)
      associate (begin => block%begin_of(block%fields(i)), length => block%fields(i)%length*block%count)
        call put_variable(self, block%before + i, block%first, block%count, block%numbers(begin:begin + length - 1), error)
      end associate
    end do
    block%count = 0
  end subroutine put_cases

  subroutine put_variable(self, i, first, cases, numbers, error)
    !! The numbers of one field of consecutive cases.
    class(result_file), intent(in) :: self
    integer, intent(in) :: i                              !! which field
    integer(i8), intent(in) :: first                      !! number of the first case
    integer, intent(in) :: cases                          !! how many
    real(dp), intent(in) :: numbers(self%fields(i)%length*cases)
    type(error_type), allocatable, intent(inout) :: error
    integer :: start(3), counts(3)                        ! NetCDF reads as many as the variable has dimensions
    if (allocated(error)) return
    associate (field => self%fields(i))
      start = 1
      counts = [field%lengths, 1]
      start(field%rank + 1) = int(first)
      counts(field%rank + 1) = cases
      if (field%is_integer) then
        call self%check(nf90_put_var(self%id, self%variables(i), int(numbers, i4), start, counts), error)
      else
        call self%check(nf90_put_var(self%id, self%variables(i), numbers, start, counts), error)
      end if
    end associate
  end subroutine put_variable

  subroutine finish(self, notes, report, seconds, error)
    !! The notes, what is printed of the numbers, and stage times, then close.
    class(result_file), intent(inout) :: self
    character(*), intent(in) :: notes, report
    real(dp), intent(in) :: seconds(:)        !! (stages)
    type(error_type), allocatable, intent(inout) :: error
    call self%put_text('notes', notes, error)
    call self%put_text('report', report, error)
    if (.not. allocated(error)) call self%check(nf90_put_var(self%id, self%seconds, seconds), error)
    call self%close(error)
  end subroutine finish

end module bw_result_file
