module bw_scene_design
  !! A `&design` as sweeps whose values vary together: one for each column of its table.
  use bw_design_par, only: design_par
  use bw_design_table, only: design_table, read_design_table
  use bw_error, only: error_type
  use bw_file_checksum, only: file_digits
  use bw_files, only: path_beside
  use bw_input_name, only: accepted_text, input_name
  use bw_input_table, only: name_table
  use bw_input_values, only: group_values, position_of
  use bw_missing, only: is_missing
  use bw_scene_checks, only: check_group
  use bw_scene_messages, only: message_list
  use bw_scene_sweeps, only: accepts, excuse_missing, groups_where
  use bw_sweep_par, only: sweep_par
  use bw_sweep_target, only: find_target, sweep_target
  use bw_text, only: text_of
  implicit none (type, external)
  private
  public :: extract_design

contains

  subroutine extract_design(file, groups, sweeps, design, messages, error)
    !! Take `&design` out of a scene and read its table; the names that it varies count as given afterwards.
    !! **Errors**: `status_bad_file` if the table cannot be read.
    character(*), intent(in) :: file                       !! of the scene
    type(group_values), allocatable, intent(inout) :: groups(:)
    type(sweep_par), allocatable, intent(inout) :: sweeps(:)
    type(design_par), allocatable, intent(inout) :: design
    type(message_list), intent(inout) :: messages
    type(error_type), allocatable, intent(inout) :: error
    type(group_values), allocatable :: remaining(:)
    type(group_values) :: source
    type(design_table) :: table
    integer :: g
    g = position_of(groups, 'design')
    if (g == 0) return
    source = groups(g)
    remaining = groups_where(groups, groups%group /= 'design')
    call move_alloc(remaining, groups)
    call check_group(source, messages)
    if (size(sweeps) > 0) call messages%add(source%line, '&design', 'excludes &sweep; accepted: one or the other')
    if (position_of(groups, 'identify') > 0) call messages%add(source%line, '&design', &
      'excludes &identify: all records are fitted together; accepted: one or the other')
    if (source%known('file') .and. size(sweeps) == 0) then
      allocate (design)
      design%file = source%text('file')
      design%line = source%line_of('file')
      design%path = path_beside(file, design%file)
      design%checksum = file_digits(design%path, error)
      call read_design_table(design%path, design%line, table, messages, error)
      call apply_columns(table, groups, sweeps, design, messages)
    end if
  end subroutine extract_design

  pure subroutine apply_columns(table, groups, sweeps, design, messages)
    !! Let each column vary the number that its name refers to.
    type(design_table), intent(in) :: table
    type(group_values), intent(inout) :: groups(:)
    type(sweep_par), allocatable, intent(inout) :: sweeps(:)
    type(design_par), intent(inout) :: design
    type(message_list), intent(inout) :: messages
    type(sweep_target) :: target
    character(:), allocatable :: problem
    integer :: i, n
    design%lines = table%lines
    deallocate (sweeps)
    allocate (sweeps(size(table%names)))
    n = 0
    do i = 1, size(table%names)
      call find_target('design', table%names(i)%text, groups, target, problem)
      if (problem /= '') then
        call messages%enter_row(design%path, table%line, design%line)
        call messages%add(design%line, 'column '//text_of(i), problem)
        call excuse_missing(table%names(i)%text, groups)
        cycle
      end if
      n = n + 1
      sweeps(n)%parameter = target%place
      sweeps(n)%spacing = ''
      sweeps(n)%values = table%numbers(i, :)
      sweeps(n)%axis = 1
      sweeps(n)%designed = .true.
      associate (value => groups(target%group)%values(target%value))
        call check_column(sweeps(n), name_table(value%row), design, messages)
        call value%follow(target%element, n, design%line, sweeps(n)%values, &
                          is_known=size(design%lines) > 0 .and. .not. any(is_missing(sweeps(n)%values)))
      end associate
    end do
    call messages%leave_row()
    sweeps = sweeps(:n)
  end subroutine apply_columns

  pure subroutine check_column(sweep, row, design, messages)
    !! Report the numbers of a column that its name would not accept.
    type(sweep_par), intent(in) :: sweep
    type(input_name), intent(in) :: row
    type(design_par), intent(in) :: design
    type(message_list), intent(inout) :: messages
    integer :: i
    do i = 1, size(sweep%values)
      if (accepts(row, sweep%values(i)) .or. is_missing(sweep%values(i))) cycle
      call messages%enter_row(design%path, design%lines(i), design%line)
      call messages%add(design%line, sweep%parameter, text_of(sweep%values(i))//' is not accepted; accepted: '//accepted_text(row))
    end do
  end subroutine check_column

end module bw_scene_design
