module bw_result_file
  !! The result of a scene: one NetCDF-4 file, made once, filled case by case.
  use bw_kinds, only: dp, i4, i8
  use bw_case_result, only: case_result, case_words
  use bw_error, only: error_type
  use bw_event, only: event_words
  use bw_missing, only: missing
  use bw_netcdf, only: check, create_file, define_variable, unwritten
  use bw_result_header, only: put_global_attributes, put_coordinates, put_inputs, swept_names
  use bw_result_layout, only: result_layout, dimension_length, has_dimension
  use bw_result_values, only: variable_row, variable_table, is_held, value_of
  use bw_scene, only: scene_type
  use bw_stopwatch, only: stage_count
  use bw_text, only: joined
  use netcdf, only: nf90_close, nf90_def_dim, nf90_double, nf90_enddef, nf90_get_var, nf90_inq_varid, nf90_int, &
    nf90_global, nf90_noerr, nf90_open, nf90_put_att, nf90_put_var, nf90_sync, nf90_write
  implicit none (type, external)
  private
  public :: create_result, reopen_result

  type, public :: result_file
    integer, private :: id = 0
    character(:), allocatable, private :: path
    type(result_layout), private :: layout
    type(variable_row), allocatable, private :: rows(:)    !! the table's rows that this result holds
  contains
    procedure :: put_case
    procedure :: finished_cases
    procedure :: save
    procedure :: finish
    procedure :: close => close_file
  end type result_file

  character(*), parameter :: dimension_names(9) = &
    [character(12) :: 'case', 'mode', 'mode_before', 'profile', 'event', 'point', 'time', 'frequency', 'peak']

contains

  subroutine create_result(path, scene, layout, file, error)
    !! A new file with all its dimensions, variables, coordinates and inputs, and no case.
    character(*), intent(in) :: path
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    type(result_file), intent(out) :: file
    type(error_type), allocatable, intent(out) :: error
    integer :: dimension, i
    call start_from(path, layout, file)
    call create_file(path, file%id, error)
    if (allocated(error)) return
    call put_global_attributes(file%id, path, scene, error)
    do i = 1, size(dimension_names)
      if (.not. has_dimension(layout, trim(dimension_names(i)))) cycle
      call check(nf90_def_dim(file%id, trim(dimension_names(i)), dimension_length(layout, trim(dimension_names(i))), &
                              dimension), path, error)
    end do
    call check(nf90_def_dim(file%id, 'stage', stage_count, dimension), path, error)
    call define_case_variables(file, swept_names(scene), error)
    call put_coordinates(file%id, path, scene, layout, error)
    call put_inputs(file%id, path, scene, error)
    if (allocated(error)) call file%close()
  end subroutine create_result

  subroutine reopen_result(path, layout, file, error)
    !! An unfinished file of the same scene and version, to go on with.
    character(*), intent(in) :: path
    type(result_layout), intent(in) :: layout
    type(result_file), intent(out) :: file
    type(error_type), allocatable, intent(out) :: error
    call start_from(path, layout, file)
    call check(nf90_open(path, nf90_write, file%id), path, error)
  end subroutine reopen_result

  subroutine start_from(path, layout, file)
    character(*), intent(in) :: path
    type(result_layout), intent(in) :: layout
    type(result_file), intent(inout) :: file
    integer :: i
    file%path = path
    file%layout = layout
    associate (table => variable_table())
      file%rows = pack(table, [(is_held(layout, table(i)), i=1, size(table))])
    end associate
  end subroutine start_from

  subroutine define_case_variables(file, swept, error)
    !! Everything that `put_case` fills.
    type(result_file), intent(in) :: file
    character(*), intent(in) :: swept                !! swept inputs, by spaces
    type(error_type), allocatable, intent(inout) :: error
    integer :: i, variable
    do i = 1, size(file%rows)
      associate (row => file%rows(i))
        call define(file, trim(row%name), trim(row%dimensions), nf90_double, trim(row%units), row%long_name, swept, &
                    variable, error)
        if (row%references /= '') call check(nf90_put_att(file%id, variable, 'references', trim(row%references)), &
                                             file%path, error)
      end associate
    end do
    call define_histories(file, swept, error)
    call define(file, 'mode_count', '', nf90_int, '1', 'number of modes', swept, variable, error)
    call define(file, 'case_status', '', nf90_int, '1', 'how the case ended', swept, variable, error)
    call put_flags(file, variable, case_words, 0, error)
    if (has_dimension(file%layout, 'peak')) &
      call define(file, 'peak_count', '', nf90_int, '1', 'number of measured peaks', swept, variable, error)
    if (has_dimension(file%layout, 'event')) then
      call define(file, 'event_kind', 'event', nf90_int, '1', 'kind of the event', swept, variable, error)
      call put_flags(file, variable, event_words, 1, error)
    end if
    call define_variable(file%id, file%path, 'stage_seconds', nf90_double, [dimension_of(file, 'stage')], 's', &
                         'wall time of the stage over all cases', variable, error)
  end subroutine define_case_variables

  subroutine define_histories(file, swept, error)
    !! The large arrays.
    type(result_file), intent(in) :: file
    character(*), intent(in) :: swept
    type(error_type), allocatable, intent(inout) :: error
    integer :: variable
    if (.not. has_dimension(file%layout, 'time')) return
    call define(file, 'displacement', 'point time', nf90_double, 'm', 'transverse displacement in the rotating frame', &
                swept, variable, error)
    call check(nf90_put_att(file%id, variable, 'references', 'Eqs 4, 13 and 29'), file%path, error)
    if (file%layout%velocity) call define(file, 'velocity', 'point time', nf90_double, 'm s-1', &
                                          'transverse velocity in the rotating frame', swept, variable, error)
    if (has_dimension(file%layout, 'frequency')) &
      call define(file, 'amplitude', 'point frequency', nf90_double, 'm', &
                  'one-sided amplitude spectrum of the displacement', swept, variable, error)
  end subroutine define_histories

  subroutine define(file, name, dimensions, kind, units, long_name, swept, variable, error)
    !! One variable over its own dimensions (in the file's order, by spaces) with `case` leading in a sweep.
    type(result_file), intent(in) :: file
    character(*), intent(in) :: name, dimensions, units, long_name, swept
    integer, intent(in) :: kind
    integer, intent(out) :: variable
    type(error_type), allocatable, intent(inout) :: error
    integer, allocatable :: ids(:)
    character(:), allocatable :: coordinates
    integer :: gap
    gap = index(dimensions, ' ')
    if (dimensions == '') then
      allocate (ids(0))
    else if (gap == 0) then
      ids = [dimension_of(file, dimensions)]
    else
      ids = [dimension_of(file, dimensions(gap + 1:)), dimension_of(file, dimensions(:gap - 1))]
    end if
    if (has_dimension(file%layout, 'case')) ids = [ids, dimension_of(file, 'case')]
    call define_variable(file%id, file%path, name, kind, ids, units, long_name, variable, error)
    coordinates = swept//position_of(dimensions)
    if (coordinates /= '') call check(nf90_put_att(file%id, variable, 'coordinates', trim(adjustl(coordinates))), &
                                      file%path, error)
  end subroutine define

  pure function position_of(dimensions) result(name)
    !! The places along the beam that belong to a variable's dimensions.
    character(*), intent(in) :: dimensions
    character(:), allocatable :: name
    name = ''
    if (index(dimensions, 'point') == 1) name = ' point_position'
    if (dimensions == 'profile') name = ' profile_position'
  end function position_of

  integer function dimension_of(file, name) result(id)
    use netcdf, only: nf90_inq_dimid
    type(result_file), intent(in) :: file
    character(*), intent(in) :: name
    integer :: status
    status = nf90_inq_dimid(file%id, name, id)
  end function dimension_of

  subroutine put_flags(file, variable, words, first, error)
    !! CF's flags: words for the numbers first, first + 1, …
    type(result_file), intent(in) :: file
    integer, intent(in) :: variable
    character(*), intent(in) :: words(:)
    integer, intent(in) :: first
    type(error_type), allocatable, intent(inout) :: error
    integer :: i
    call check(nf90_put_att(file%id, variable, 'flag_values', [(int(i, i4), i=first, first + size(words) - 1)]), &
               file%path, error)
    call check(nf90_put_att(file%id, variable, 'flag_meanings', joined(words)), file%path, error)
  end subroutine put_flags

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
    if (has_dimension(self%layout, 'peak')) &
      call put_integers(self, index, 'peak_count', [result%measured%peak_count], .false., error)
    call put_integers(self, index, 'mode_count', [result%modes%count], .false., error)
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

  subroutine finished_cases(self, finished, error)
    !! Which cases the file already holds.
    class(result_file), intent(in) :: self
    logical, allocatable, intent(out) :: finished(:)    !! (cases), at least (1)
    type(error_type), allocatable, intent(out) :: error
    integer(i4) :: status(max(1, self%layout%cases))
    integer :: variable
    call check(nf90_inq_varid(self%id, 'case_status', variable), self%path, error)
    status = unwritten
    if (.not. allocated(error)) call check(nf90_get_var(self%id, variable, status), self%path, error)
    finished = status /= unwritten
  end subroutine finished_cases

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
