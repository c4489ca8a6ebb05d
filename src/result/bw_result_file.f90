module bw_result_file
  !! The result of a scene: one NetCDF-4 file. Every number of every case is written once, by blocks of cases; where histories
  !! are long, `bw_result_body` writes them, and this module only what comes before the first case and after the last.
  use bw_kinds, only: dp, i4, i8
  use bw_case_fields, only: case_field, fields_of, put_field
  use bw_case_block, only: case_block
  use bw_case_places, only: mark_of
  use bw_case_result, only: case_result
  use bw_error, only: error_type
  use bw_late_values, only: late_values
  use bw_netcdf, only: check, create_file, plain_path
  use bw_result_definition, only: define_dimensions, define_variables, open_file
  use bw_result_header, only: put_global_attributes, put_coordinates, put_inputs, swept_names
  use bw_result_layout, only: result_layout
  use bw_scene, only: scene_type
  use netcdf, only: nf90_close, nf90_global, nf90_inq_varid, nf90_nofill, nf90_open, nf90_put_att, nf90_put_var, nf90_set_fill, &
    nf90_write
  implicit none (type, external)
  private
  public :: create_result, open_result

  type, extends(open_file), public :: result_file
    type(case_field), allocatable, private :: fields(:)   !! what depends on the case
    integer, allocatable, private :: variables(:)         !! NetCDF's numbers of them
  contains
    procedure :: put_case
    procedure :: put_cases
    procedure :: put_marks
    procedure :: finish
    procedure :: close => close_file
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
    if (allocated(error)) call file%close()
  end subroutine create_result

  subroutine open_result(path, file, error)
    !! A file that has all of its cases, to be finished.
    character(*), intent(in) :: path
    type(result_file), intent(out) :: file
    type(error_type), allocatable, intent(inout) :: error
    file%path = path
    if (.not. allocated(error)) call check(nf90_open(plain_path(path), nf90_write, file%id), path, error)
  end subroutine open_result

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

  subroutine put_cases(self, first, block, error)
    !! Consecutive cases of a sweep.
    class(result_file), intent(in) :: self
    integer(i8), intent(in) :: first                      !! number of the first of them
    type(case_block), intent(in) :: block
    type(error_type), allocatable, intent(inout) :: error
    integer :: i
    do i = 1, size(self%fields)
      associate (begin => block%begin_of(self%fields(i)), length => self%fields(i)%length*block%held)
        call put_variable(self, i, first, block%held, block%numbers(begin:begin + length - 1), error)
      end associate
    end do
  end subroutine put_cases

  subroutine put_marks(self, error)
    !! Marks for the last case, by which the file gets room for all cases.
    class(result_file), intent(in) :: self
    type(error_type), allocatable, intent(inout) :: error
    real(dp), allocatable :: marks(:)
    integer :: i
    do i = 1, size(self%fields)
      allocate (marks(self%fields(i)%length), source=mark_of(i))
      call put_variable(self, i, int(self%layout%cases, i8), 1, marks, error)
      deallocate (marks)
    end do
  end subroutine put_marks

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
    type(error_type), allocatable, intent(out) :: error
    integer :: variable
    call check(nf90_put_att(self%id, nf90_global, 'notes', notes), self%path, error)
    call check(nf90_inq_varid(self%id, 'stage_seconds', variable), self%path, error)
    call check(nf90_put_var(self%id, variable, seconds), self%path, error)
    call self%close(error)
  end subroutine finish

  subroutine close_file(self, error)
    !! Close; after an error without a word.
    class(result_file), intent(inout) :: self
    type(error_type), allocatable, intent(inout), optional :: error
    integer :: status
    status = nf90_close(self%id)
    if (present(error)) call check(status, self%path, error)
  end subroutine close_file

end module bw_result_file
