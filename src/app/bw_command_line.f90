module bw_command_line
  !! Parsing of the command line by the table of commands.
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use bw_command_table, only: accepted_options, command_row, command_type, commands_text, help_text, lists, options, row_of
  use bw_error, only: error_type, fail, status_bad_input
  use bw_kinds, only: dp
  use bw_text, only: append, shortened
  implicit none (type, external)
  private
  public :: read_command_line

contains

  subroutine read_command_line(rows, command, error)
    !! Read the command, its words and its options.
    !! **Errors**: `status_bad_input`, naming what is accepted.
    type(command_row), intent(in) :: rows(:)      !! all commands
    type(command_type), intent(inout) :: command  !! everything but its group is set
    type(error_type), allocatable, intent(out) :: error
    integer :: i
    command%output = 'output'
    allocate (command%words(0))
    if (command_argument_count() == 0) then
      call fail(error, status_bad_input, 'beamwave: a command is missing'//new_line('a')//help_text(rows))
      return
    end if
    i = row_of(rows, argument(1))
    if (i == 0) then
      call fail(error, status_bad_input, 'beamwave: '''//shortened(argument(1))//''' is not a command; accepted: '// &
                commands_text(rows))
      return
    end if
    command%row = rows(i)
    i = 2
    do while (i <= command_argument_count() .and. .not. allocated(error))
      call read_word(rows, command, i, error)
    end do
    if (allocated(error)) return
    associate (rule => command%row%words, count => size(command%words))
      if (count < rule%fewest .or. count > rule%most) call fail(error, status_bad_input, &
        'beamwave '//trim(command%row%name)//': '//trim(rule%complaint))
    end associate
    if (command%has_part .and. command%overwrite .and. .not. allocated(error)) call fail(error, status_bad_input, &
      'beamwave: --part and --overwrite: one part would remove the work of the others; accepted: one of them')
    if (command%quiet .and. command%verbose .and. .not. allocated(error)) call fail(error, status_bad_input, &
      'beamwave: --quiet and --verbose exclude each other; accepted: one of them')
  end subroutine read_command_line

  subroutine read_word(rows, command, i, error)
    !! Read a word of the command, or an option: `--name`, `--name value` or `--name=value`. `--help` after any command
    !! requests help.
    type(command_row), intent(in) :: rows(:)
    type(command_type), intent(inout) :: command
    integer, intent(inout) :: i                   !! index of the word; advances past it and its value
    type(error_type), allocatable, intent(out) :: error
    character(:), allocatable :: word, name
    integer :: help
    word = argument(i)
    i = i + 1
    if (len(word) < 2 .or. index(word, '-') /= 1) then
      call append(command%words, word)
      return
    end if
    name = word(:index(word//'=', '=') - 1)
    help = row_of(rows, 'help')
    if (lists(rows(help)%flags, name)) then
      command%row = rows(help)
    else if (lists(command%row%options, name)) then
      call read_option(command, word, name, i, error)
    else
      call fail(error, status_bad_input, 'beamwave '//trim(command%row%name)//': '''//shortened(name)// &
                ''' is not an option of this command'//accepted_options(command%row))
    end if
  end subroutine read_word

  subroutine read_option(command, word, name, i, error)
    !! Read an option of the command, and its value: the text after '=', or the next word.
    type(command_type), intent(inout) :: command
    character(*), intent(in) :: word              !! with its '=' and value, if any
    character(*), intent(in) :: name
    integer, intent(inout) :: i                   !! index of the next word; advances past a value
    type(error_type), allocatable, intent(inout) :: error
    character(:), allocatable :: value
    value = ''
    if (any(options%name == name .and. options%value == '')) then
      if (len(word) > len(name)) call fail(error, status_bad_input, 'beamwave: '//name//' takes no value')
    else
      if (len(word) > len(name)) then
        value = word(len(name) + 2:)
      else if (i <= command_argument_count()) then
        value = argument(i)
        i = i + 1
      end if
      if (len(value) == 0) call fail(error, status_bad_input, 'beamwave: '//word//' needs a value')
    end if
    if (.not. allocated(error)) call set_option(command, name, value, error)
  end subroutine read_option

  subroutine set_option(command, name, value, error)
    !! Put the value of an option into its component of the command.
    !! **Errors**: the value is invalid.
    type(command_type), intent(inout) :: command
    character(*), intent(in) :: name
    character(*), intent(in) :: value             !! empty for an option without value
    type(error_type), allocatable, intent(inout) :: error
    select case (name)
    case ('--output'); command%output = value
    case ('--overwrite'); command%overwrite = .true.
    case ('--quiet'); command%quiet = .true.
    case ('--verbose'); command%verbose = .true.
    case ('--max-seconds'); call read_seconds(value, command%max_seconds, error)
    case ('--json'); command%json = .true.
    case ('--progress')
      command%json = value == 'json'
      if (.not. command%json) call fail(error, status_bad_input, 'beamwave: --progress: '''//shortened(value)// &
                                        ''' is not a known format; accepted: json')
    case ('--part')
      command%has_part = .true.
      call read_part(value, command%part, error)
    end select
  end subroutine set_option

  subroutine read_seconds(value, seconds, error)
    !! Read a number of seconds.
    !! **Errors**: the value is not a finite number ≥ 0.
    character(*), intent(in) :: value
    real(dp), intent(inout) :: seconds
    type(error_type), allocatable, intent(inout) :: error
    real(dp) :: number
    integer :: stat
    stat = verify(value, '0123456789.+-eEdD')
    if (stat == 0) read (value, *, iostat=stat) number
    if (stat == 0) then
      if (.not. ieee_is_finite(number) .or. number < 0.0_dp) stat = 1
    end if
    if (stat == 0) then
      seconds = number
    else
      call fail(error, status_bad_input, 'beamwave: --max-seconds: '''//shortened(value)// &
                ''' is not a number of seconds; accepted: a number >= 0')
    end if
  end subroutine read_seconds

  subroutine read_part(value, part, error)
    !! Read which of how many parts to run.
    !! **Errors**: the value is not I/N.
    character(*), intent(in) :: value
    integer, intent(inout) :: part(2)
    type(error_type), allocatable, intent(inout) :: error
    character(*), parameter :: digits = '0123456789'
    integer :: numbers(2), slash, stat
    slash = index(value, '/')
    stat = merge(0, 1, verify(value, digits) == slash .and. verify(value(slash + 1:), digits) == 0)
    if (stat == 0) read (value(:slash - 1), *, iostat=stat) numbers(1)
    if (stat == 0) read (value(slash + 1:), *, iostat=stat) numbers(2)
    if (stat == 0) stat = merge(0, 1, numbers(1) >= 1 .and. numbers(1) <= numbers(2))
    if (stat == 0) part = numbers
    if (stat /= 0) call fail(error, status_bad_input, 'beamwave: --part: '''//shortened(value)// &
      ''' is not a part; accepted: I/N, whole numbers from 1 on, I at most N')
  end subroutine read_part

  function argument(i) result(text)
    !! Return a word of the command line, from 1.
    integer, intent(in) :: i
    character(:), allocatable :: text
    integer :: length
    call get_command_argument(i, length=length)
    allocate (character(length) :: text)
    if (length > 0) call get_command_argument(i, text)
  end function argument

end module bw_command_line
