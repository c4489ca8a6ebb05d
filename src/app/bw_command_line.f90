module bw_command_line
  !! The words of the command line.
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use bw_error, only: error_type, fail, status_bad_input
  use bw_kinds, only: dp
  use bw_text, only: append, string
  implicit none (type, external)
  private
  public :: read_command_line, help_text

  type, public :: command_type
    character(:), allocatable :: name             !! run, check, accuracy, effects, describe, help, version
    type(string), allocatable :: words(:)         !! paths of scenes, or the group to describe
    character(:), allocatable :: output           !! --output
    logical :: overwrite = .false.                !! --overwrite
    logical :: quiet = .false.                    !! --quiet
    real(dp) :: max_seconds = huge(1.0_dp)        !! --max-seconds
  end type command_type

contains

  subroutine read_command_line(command, error)
    !! The command, its words and options. **Errors**: `status_bad_input`, naming what is accepted.
    type(command_type), intent(out) :: command
    type(error_type), allocatable, intent(out) :: error
    character(:), allocatable :: word
    integer :: i
    command%output = 'output'
    allocate (command%words(0))
    if (command_argument_count() == 0) then
      call fail(error, status_bad_input, 'beamwave: a command is missing'//new_line('a')//help_text())
      return
    end if
    command%name = command_name(argument(1))
    if (command%name == '') then
      call fail(error, status_bad_input, 'beamwave: '''//argument(1)// &
                ''' is not a command; accepted: run, check, accuracy, effects, describe, --help, --version')
      return
    end if
    i = 2
    do while (i <= command_argument_count())
      word = argument(i)
      if (len(word) > 1 .and. word(:min(1, len(word))) == '-') then
        call read_option(command, word, i, error)
      else
        call append(command%words, word)
      end if
      if (allocated(error)) return
      i = i + 1
    end do
    call check_words(command, error)
  end subroutine read_command_line

  pure function command_name(word) result(name)
    !! Empty for a word that is not a command.
    character(*), intent(in) :: word
    character(:), allocatable :: name
    select case (word)
    case ('run', 'check', 'accuracy', 'effects', 'describe'); name = word
    case ('--help', '-h', 'help'); name = 'help'
    case ('--version', '-V', 'version'); name = 'version'
    case default; name = ''
    end select
  end function command_name

  subroutine read_option(command, word, i, error)
    !! `--name value` or `--name=value`.
    type(command_type), intent(inout) :: command
    character(*), intent(in) :: word
    integer, intent(inout) :: i                   !! place of the word; moves on with a value of its own
    type(error_type), allocatable, intent(out) :: error
    character(:), allocatable :: name, value
    integer :: equals
    equals = index(word, '=')
    name = word
    if (equals > 0) name = word(:equals - 1)
    if (name == '--help' .or. name == '-h') then
      command%name = 'help'
    else if (.not. takes(command%name, name)) then
      call fail(error, status_bad_input, 'beamwave '//command%name//': '''//name//''' is not an option of this command'// &
                accepted_options(command%name))
    else if (name == '--overwrite' .or. name == '--quiet') then
      if (equals > 0) call fail(error, status_bad_input, 'beamwave: '//name//' takes no value')
      if (name == '--overwrite') command%overwrite = .true.
      if (name == '--quiet') command%quiet = .true.
    else
      call take_value(word, equals, i, value, error)
      if (.not. allocated(error)) call set_value(command, name, value, error)
    end if
  end subroutine read_option

  subroutine take_value(word, equals, i, value, error)
    character(*), intent(in) :: word
    integer, intent(in) :: equals
    integer, intent(inout) :: i
    character(:), allocatable, intent(out) :: value
    type(error_type), allocatable, intent(out) :: error
    value = ''
    if (equals > 0) then
      value = word(equals + 1:)
    else if (i < command_argument_count()) then
      i = i + 1
      value = argument(i)
    end if
    if (len(value) == 0) call fail(error, status_bad_input, 'beamwave: '//word//' needs a value')
  end subroutine take_value

  subroutine set_value(command, name, value, error)
    type(command_type), intent(inout) :: command
    character(*), intent(in) :: name, value
    type(error_type), allocatable, intent(out) :: error
    real(dp) :: seconds
    integer :: stat
    if (name == '--output') then
      command%output = value
      return
    end if
    stat = verify(value, '0123456789.+-eEdD')
    if (stat == 0) read (value, *, iostat=stat) seconds
    if (stat == 0) then
      if (.not. ieee_is_finite(seconds) .or. seconds < 0.0_dp) stat = 1
    end if
    if (stat == 0) then
      command%max_seconds = seconds
    else
      call fail(error, status_bad_input, 'beamwave: --max-seconds: '''//value// &
                ''' is not a number of seconds; accepted: a number >= 0')
    end if
  end subroutine set_value

  pure logical function takes(command, option)
    !! Whether a command has an option.
    character(*), intent(in) :: command, option
    select case (option)
    case ('--max-seconds'); takes = command == 'run'
    case ('--output', '--overwrite'); takes = any(command == [character(8) :: 'run', 'accuracy', 'effects'])
    case ('--quiet'); takes = any(command == [character(8) :: 'run', 'check', 'accuracy', 'effects'])
    case default; takes = .false.
    end select
  end function takes

  pure function accepted_options(command) result(text)
    character(*), intent(in) :: command
    character(:), allocatable :: text
    select case (command)
    case ('run'); text = '; accepted: --output DIR, --overwrite, --quiet, --max-seconds S'
    case ('accuracy', 'effects'); text = '; accepted: --output DIR, --overwrite, --quiet'
    case ('check'); text = '; accepted: --quiet'
    case default; text = ''
    end select
  end function accepted_options

  subroutine check_words(command, error)
    !! Scenes where they are needed, no words where they are not.
    type(command_type), intent(in) :: command
    type(error_type), allocatable, intent(out) :: error
    select case (command%name)
    case ('run', 'check')
      if (size(command%words) == 0) call fail(error, status_bad_input, &
        'beamwave '//command%name//': a scene is missing; accepted: files, or directories of *.nml')
    case ('accuracy', 'effects')
      if (size(command%words) /= 1) call fail(error, status_bad_input, &
        'beamwave '//command%name//': accepted: one scene')
    case default
      if (size(command%words) > 1) call fail(error, status_bad_input, 'beamwave '//command%name//': accepted: one word at most')
    end select
  end subroutine check_words

  function argument(i) result(text)
    integer, intent(in) :: i
    character(:), allocatable :: text
    integer :: length
    call get_command_argument(i, length=length)
    allocate (character(length) :: text)
    if (length > 0) call get_command_argument(i, text)
  end function argument

  pure function help_text() result(text)
    !! What `beamwave --help` prints.
    character(:), allocatable :: text
    character(*), parameter :: nl = new_line('a')
    text = 'beamwave: bending waves in a rotating beam struck at its tip'//nl//nl// &
      '  beamwave run PATH ...         run scenes; a directory stands for its *.nml'//nl// &
      '  beamwave check PATH ...       read and validate; say what would be simulated, how, and what it would take'//nl// &
      '  beamwave accuracy SCENE.nml   measure what accuracy costs on this scene'//nl// &
      '  beamwave effects SCENE.nml    for each effect: on or off, what it changes, what it costs'//nl// &
      '  beamwave describe [GROUP]     every input name: type, unit, range, default, meaning'//nl// &
      '  beamwave --help | --version'//nl// &
      '  mpirun -n N beamwave-mpi run PATH ...   shares the cases of sweeps among N processes; the same words'//nl//nl// &
      '  check takes --quiet; accuracy and effects all of these but the last; run takes'//nl// &
      '    --output DIR       where results go (output)'//nl// &
      '    --overwrite        replace results of other scenes or versions'//nl// &
      '    --quiet            print warnings and errors only'//nl// &
      '    --max-seconds S    stop in order after so long; the same command goes on from there'//nl//nl// &
      '  exit status: 0 done, 2 bad command line or scene, 3 a file or memory was refused, 4 some numbers'//nl// &
      '  cannot be trusted, 5 stopped in order, 70 a fault in the program'
  end function help_text

end module bw_command_line
