module bw_result_file
  !! The result of a scene: one NetCDF-4 file, made once, filled case by case.
  use bw_kinds, only: dp, i4, i8
  use bw_case_result, only: case_result
  use bw_error, only: error_type
  use bw_netcdf, only: check, create_file, unwritten
  use bw_result_definition, only: define_dimensions, define_variables, open_file
  use bw_result_header, only: put_global_attributes, put_coordinates, put_inputs, swept_names
  use bw_result_layout, only: result_layout, has_dimension
  use bw_result_table, only: variable_row, variable_table, is_held
  use bw_result_values, only: value_of
  use bw_scene, only: scene_type
  use netcdf, only: nf90_close, nf90_get_var, nf90_global, nf90_inq_varid, nf90_open, nf90_put_att, nf90_put_var, &
    nf90_sync, nf90_write
  implicit none (type, external)
  private
  public :: create_result, reopen_result

  type, extends(open_file), public :: result_file
    type(variable_row), allocatable, private :: rows(:)    !! the table's rows that this result holds
  contains
    procedure :: put_case
    procedure :: case_states
    procedure :: save
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
    call start_from(path, scene, layout, file)
    call create_file(path, file%id, error)
    if (allocated(error)) return
    call put_global_attributes(file%id, path, scene, error)
    call define_dimensions(file%open_file, error)
    call define_variables(file%open_file, file%rows, error)
    call put_coordinates(file%id, path, scene, layout, error)
    call put_inputs(file%id, path, scene, error)
    call check(nf90_sync(file%id), path, error)      ! a killed run leaves all of this, or no file to go on with
    if (allocated(error)) call file%close()
  end subroutine create_result

  subroutine reopen_result(path, scene, layout, file, error)
    !! An unfinished file of the same scene and version, to go on with.
    character(*), intent(in) :: path
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    type(result_file), intent(out) :: file
    type(error_type), allocatable, intent(out) :: error
    call start_from(path, scene, layout, file)
    call check(nf90_open(path, nf90_write, file%id), path, error)
  end subroutine reopen_result

  subroutine start_from(path, scene, layout, file)
    character(*), intent(in) :: path
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    type(result_file), intent(inout) :: file
    integer :: i
    file%path = path
    file%layout = layout
    file%swept = swept_names(scene)
    associate (table => variable_table())
      file%rows = pack(table, [(is_held(layout, table(i)), i=1, size(table))])
    end associate
  end subroutine start_from

  subroutine put_case(self, index, result, error)
    !! Write one case; its `case_status` comes last and says that it is there.
    class(result_file), intent(inout) :: self
    integer(i8), intent(in) :: index          !! from 1
    type(case_result), intent(in) :: result
    type(error_type), allocatable, intent(out) :: error
    integer :: i
    do i = 1, size(self%rows)
      call put_vector(self, index, trim(self%rows(i)%name), value_of(result, self%rows(i)), &
                      self%rows(i)%dimensions /= '', error)
    end do
    if (allocated(result%response)) call put_histories(self, index, result, error)
    if (allocated(result%events)) call put_integers(self, index, 'event_kind', result%events%kind, .true., error)
    if (has_dimension(self%layout, 'peak')) then
      call put_integers(self, index, 'peak_count', [result%measured%peak_count], .false., error)
    end if
    call put_integers(self, index, 'mode_count', [result%mode_count], .false., error)
    call put_integers(self, index, 'case_status', [result%status], .false., error)
  end subroutine put_case

  subroutine put_histories(self, index, result, error)
    class(result_file), intent(in) :: self
    integer(i8), intent(in) :: index
    type(case_result), intent(in) :: result
    type(error_type), allocatable, intent(inout) :: error
    call put_matrix(self, index, 'displacement', result%response%displacement, error)
    if (allocated(result%response%velocity)) call put_matrix(self, index, 'velocity', result%response%velocity, error)
    if (allocated(result%amplitude)) call put_matrix(self, index, 'amplitude', result%amplitude, error)
  end subroutine put_histories

  subroutine put_vector(self, index, name, values, is_array, error)
    !! What is shorter than its dimension leaves the rest unwritten, which reads as fill.
    class(result_file), intent(in) :: self
    integer(i8), intent(in) :: index
    character(*), intent(in) :: name
    real(dp), intent(in) :: values(:)
    logical, intent(in) :: is_array           !! the variable has a dimension of its own
    type(error_type), allocatable, intent(inout) :: error
    integer :: variable, start(2), counts(2)
    if (size(values) == 0 .or. allocated(error)) return
    call check(nf90_inq_varid(self%id, name, variable), self%path, error)
    call place(self, index, size(values), is_array, start, counts)
    call check(nf90_put_var(self%id, variable, values, start, counts), self%path, error)
  end subroutine put_vector

  subroutine put_integers(self, index, name, values, is_array, error)
    class(result_file), intent(in) :: self
    integer(i8), intent(in) :: index
    character(*), intent(in) :: name
    integer, intent(in) :: values(:)
    logical, intent(in) :: is_array
    type(error_type), allocatable, intent(inout) :: error
    integer :: variable, start(2), counts(2)
    if (allocated(error)) return
    call check(nf90_inq_varid(self%id, name, variable), self%path, error)
    call place(self, index, size(values), is_array, start, counts)
    call check(nf90_put_var(self%id, variable, values, start, counts), self%path, error)
  end subroutine put_integers

  subroutine put_matrix(self, index, name, values, error)
    class(result_file), intent(in) :: self
    integer(i8), intent(in) :: index
    character(*), intent(in) :: name
    real(dp), intent(in) :: values(:, :)      !! fastest dimension first
    type(error_type), allocatable, intent(inout) :: error
    integer :: variable
    if (allocated(error)) return
    call check(nf90_inq_varid(self%id, name, variable), self%path, error)
    call check(nf90_put_var(self%id, variable, values, [1, 1, int(index)], [shape(values), 1]), self%path, error)
  end subroutine put_matrix

  pure subroutine place(self, index, length, is_array, start, counts)
    !! Where a case's values stand: NetCDF reads as many entries as the variable has dimensions.
    class(result_file), intent(in) :: self
    integer(i8), intent(in) :: index
    integer, intent(in) :: length
    logical, intent(in) :: is_array
    integer, intent(out) :: start(2), counts(2)
    start = [1, int(index)]
    counts = [length, 1]
    if (is_array) return
    start(1) = int(index)
    counts(1) = 1
    if (.not. has_dimension(self%layout, 'case')) start(1) = 1
  end subroutine place

  subroutine case_states(self, status, error)
    !! `case_status` of every case; `unwritten` where the file does not hold it yet.
    class(result_file), intent(in) :: self
    integer(i4), allocatable, intent(out) :: status(:)    !! (cases), at least (1)
    type(error_type), allocatable, intent(out) :: error
    integer :: variable
    allocate (status(max(1, self%layout%cases)), source=unwritten)
    call check(nf90_inq_varid(self%id, 'case_status', variable), self%path, error)
    if (.not. allocated(error)) call check(nf90_get_var(self%id, variable, status), self%path, error)
  end subroutine case_states

  subroutine save(self, error)
    !! Bring what was put so far to the disk.
    class(result_file), intent(in) :: self
    type(error_type), allocatable, intent(out) :: error
    call check(nf90_sync(self%id), self%path, error)
  end subroutine save

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
    call check(nf90_close(self%id), self%path, error)
  end subroutine finish

  subroutine close_file(self)
    !! Close without a word: after an error, or where the work is left for later.
    class(result_file), intent(inout) :: self
    integer :: ignored
    ignored = nf90_close(self%id)
  end subroutine close_file

end module bw_result_file
