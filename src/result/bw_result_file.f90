module bw_result_file
  !! The result of a scene: one NetCDF-4 file. Every number of every case is written once: long histories and spectra case by
  !! case, all else by blocks of cases. After a failure the file is not touched any more, as HDF5 does not bear that: who writes
  !! it does so in a process of its own.
  use bw_kinds, only: dp, i4, i8
  use bw_case_fields, only: case_field, fields_of, put_field, short_fields
  use bw_case_block, only: case_block
  use bw_case_result, only: case_result
  use bw_error, only: error_type
  use bw_late_values, only: late_values
  use bw_netcdf, only: check, create_file
  use bw_result_definition, only: define_dimensions, define_variables, open_file
  use bw_result_header, only: put_global_attributes, put_coordinates, put_inputs, swept_names
  use bw_result_layout, only: result_layout
  use bw_scene, only: scene_type
  use netcdf, only: nf90_close, nf90_global, nf90_inq_varid, nf90_nofill, nf90_put_att, nf90_put_var, nf90_set_fill
  implicit none (type, external)
  private
  public :: create_result

  type, extends(open_file), public :: result_file
    type(case_field), allocatable, private :: fields(:)   !! what depends on the case
    integer, allocatable, private :: variables(:)         !! NetCDF's numbers of them
  contains
    procedure :: put_case
    procedure :: put_long_fields
    procedure :: put_cases
    procedure :: finish
  end type result_file

contains

  subroutine create_result(path, scene, layout, file, error)
    !! A new file with all its dimensions, variables, coordinates and inputs, and no case.
    character(*), intent(in) :: path
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    type(result_file), intent(out) :: file
    type(error_type), allocatable, intent(out) :: error
    type(late_values) :: late
    integer :: former
    file%path = path
    file%layout = layout
    file%swept = swept_names(scene)
    file%fields = fields_of(layout)
    call create_file(path, file%id, error)
    if (allocated(error)) return
    call check(nf90_set_fill(file%id, nf90_nofill, former), path, error)    ! no array is written twice
    call put_global_attributes(file%id, path, scene, error)
    call define_dimensions(file%open_file, error)
    call define_variables(file%open_file, error)
    call put_coordinates(file%id, path, scene, layout, late, error)
    call put_inputs(file%id, path, scene, late, error)
    call late%put_all(file%id, path, error)
    call find_variables(file, error)
  end subroutine create_result

  subroutine find_variables(file, error)
    !! NetCDF's numbers, asked for once.
    type(result_file), intent(inout) :: file
    type(error_type), allocatable, intent(inout) :: error
    integer :: i
    if (allocated(error)) return
    allocate (file%variables(size(file%fields)))
    do i = 1, size(file%fields)
      call check(nf90_inq_varid(file%id, trim(file%fields(i)%name), file%variables(i)), file%path, error)
    end do
  end subroutine find_variables

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

  subroutine put_long_fields(self, index, numbers, error)
    !! The long histories and spectra of one case of a sweep.
    class(result_file), intent(in) :: self
    integer(i8), intent(in) :: index                      !! of the case
    real(dp), intent(in), contiguous :: numbers(:)        !! all of the case
    type(error_type), allocatable, intent(inout) :: error
    integer :: i
    do i = short_fields(self%fields) + 1, size(self%fields)
      associate (first => self%fields(i)%first, length => self%fields(i)%length)
        call put_variable(self, i, index, 1, numbers(first:first + length - 1), error)
      end associate
    end do
  end subroutine put_long_fields

  subroutine put_cases(self, first, block, error)
    !! What is not long of consecutive cases of a sweep.
    class(result_file), intent(in) :: self
    integer(i8), intent(in) :: first                      !! number of the first of them
    type(case_block), intent(in) :: block
    type(error_type), allocatable, intent(inout) :: error
    integer :: i
    do i = 1, short_fields(self%fields)
      associate (begin => block%begin_of(self%fields(i)), length => self%fields(i)%length*block%held)
        call put_variable(self, i, first, block%held, block%numbers(begin:begin + length - 1), error)
      end associate
    end do
  end subroutine put_cases

  subroutine put_variable(self, i, first, cases, numbers, error)
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
        call check(nf90_put_var(self%id, self%variables(i), int(numbers, i4), start, counts), self%path, error)
      else
        call check(nf90_put_var(self%id, self%variables(i), numbers, start, counts), self%path, error)
      end if
    end associate
  end subroutine put_variable

  subroutine finish(self, notes, seconds, error)
    !! The notes and stage times, then close.
    class(result_file), intent(inout) :: self
    character(*), intent(in) :: notes
    real(dp), intent(in) :: seconds(:)        !! (stages)
    type(error_type), allocatable, intent(inout) :: error
    integer :: variable
    if (allocated(error)) return
    call check(nf90_put_att(self%id, nf90_global, 'notes', notes), self%path, error)
    call check(nf90_inq_varid(self%id, 'stage_seconds', variable), self%path, error)
    call check(nf90_put_var(self%id, variable, seconds), self%path, error)
    if (.not. allocated(error)) call check(nf90_close(self%id), self%path, error)
  end subroutine finish

end module bw_result_file
