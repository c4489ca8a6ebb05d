module bw_command_table
  !! The rows of the table of commands, and texts derived from them: the help, and the accepted words in messages. The rows
  !! themselves are in `bw_main`. A new option is a row of `options` here and a case of `set_option` in `bw_command_line`.
  use bw_kinds, only: dp
  use bw_process_group, only: process_group
  use bw_text, only: string
  implicit none (type, external)
  private
  public :: row_of, lists, commands_text, accepted_options, help_text

  type, public :: words_rule
    !! Which words a command takes besides its options.
    character(12) :: usage = ''                   !! as shown by the help
    integer :: fewest = 0, most = 1
    character(64) :: complaint = 'accepted: one word at most'
  end type words_rule

  type(words_rule), parameter, public :: &
    some_scenes = words_rule('PATH ...', 1, huge(1), 'a scene is missing; accepted: files, or directories of *.nml'), &
    one_scene = words_rule('SCENE.nml', 1, 1, 'accepted: one scene'), &
    one_group = words_rule('[GROUP]'), no_words = words_rule()

  type, public :: command_row
    !! A command, as needed for parsing, help, messages and dispatch.
    character(8) :: name = ''
    type(words_rule) :: words
    character(96) :: options = ''                 !! its `options`, in their order, separated by spaces
    character(96) :: help = ''                    !! what it does
    procedure(command_interface), pointer, nopass :: procedure => null()
    character(16) :: flags = ''                   !! equivalent `--word`s, separated by spaces; help names the first
    logical :: shared = .false.                   !! called by all processes of a group, else by the leader alone
  end type command_row

  type, public :: command_type
    !! A command as called.
    type(command_row), allocatable :: row         !! its row of the table
    type(string), allocatable :: words(:)         !! paths of scenes, or the group to describe
    character(:), allocatable :: output           !! --output
    logical :: overwrite = .false.                !! --overwrite
    logical :: quiet = .false.                    !! --quiet
    logical :: verbose = .false.                  !! --verbose
    real(dp) :: max_seconds = huge(1.0_dp)        !! --max-seconds
    integer :: part(2) = 1                        !! --part: index and number of parts
    logical :: has_part = .false.                 !! it is given
    logical :: json = .false.                     !! --json, or --progress json
    class(process_group), pointer :: group => null()    !! the processes started together
  end type command_type

  abstract interface
    integer function command_interface(command) result(status)
      !! Executes the command, prints its output, and returns the exit status.
      import :: command_type
      type(command_type), intent(in) :: command
    end function command_interface
  end interface

  type, public :: option_row
    character(16) :: name
    character(4) :: value                         !! placeholder of its value in the help; blank for an option without value
    character(80) :: help
  end type option_row

  type(option_row), parameter, public :: options(*) = [ &
    option_row('--output', 'DIR', 'where results go (output)'), &
    option_row('--overwrite', '', 'replace results of other scenes or versions'), &
    option_row('--quiet', '', 'print warnings and errors only'), &
    option_row('--verbose', '', 'print the whole report instead of one screen'), &
    option_row('--max-seconds', 'S', 'stop after S seconds, finished cases saved; the same command goes on from there'), &
    option_row('--part', 'I/N', 'run the cases i = I mod N of a sweep; N such commands share it without MPI'), &
    option_row('--progress', 'json', 'report progress, warnings and errors as lines of JSON on standard error'), &
    option_row('--json', '', 'print one JSON document for programs')]

  character(*), parameter :: nl = new_line('a')

contains

  pure integer function row_of(rows, word) result(i)
    !! Return the index of the command that a word names; 0 if none.
    type(command_row), intent(in) :: rows(:)
    character(*), intent(in) :: word
    do i = size(rows), 1, -1
      if (word == rows(i)%name .or. lists(rows(i)%flags, word)) return
    end do
  end function row_of

  elemental logical function lists(list, word)
    !! Return whether a word is in a list separated by blanks.
    character(*), intent(in) :: list, word
    lists = .false.
    if (word == '' .or. index(trim(word), ' ') > 0) return
    lists = index(' '//list//' ', ' '//trim(word)//' ') > 0
  end function lists

  pure function commands_text(rows) result(text)
    !! List all commands for a message, by the words that users call.
    type(command_row), intent(in) :: rows(:)
    character(:), allocatable :: text
    integer :: i
    text = ''
    do i = 1, size(rows)
      text = text//', '//called(rows(i))
    end do
    text = text(3:)
  end function commands_text

  pure function called(row) result(word)
    !! Return the word by which users call a command.
    type(command_row), intent(in) :: row
    character(:), allocatable :: word
    word = trim(row%name)
    if (row%flags /= '') word = row%flags(:index(row%flags, ' ') - 1)
  end function called

  pure function accepted_options(row) result(text)
    !! List the options of a command for a message, if it takes any.
    type(command_row), intent(in) :: row
    character(:), allocatable :: text
    integer :: i
    text = ''
    do i = 1, size(options)
      if (.not. lists(row%options, options(i)%name)) cycle
      text = text//', '//trim(trim(options(i)%name)//' '//options(i)%value)
    end do
    if (text /= '') text = '; accepted: '//text(3:)
  end function accepted_options

  pure function help_text(rows) result(text)
    !! Return the output of `beamwave --help`: commands, options and exit statuses.
    type(command_row), intent(in) :: rows(:)
    character(:), allocatable :: text, flags
    integer :: i
    text = 'beamwave: bending waves in a beam, at rest or rotating, that is struck by a mass, simulated or measured'//nl//nl
    flags = ''
    do i = 1, size(rows)
      if (rows(i)%flags == '') text = text//column('  beamwave '//usage(rows(i)), 32)//trim(rows(i)%help)//nl
      if (rows(i)%flags /= '') flags = flags//' | '//called(rows(i))
    end do
    text = text//'  beamwave '//flags(4:)//nl
    do i = 1, size(rows)
      if (rows(i)%shared) text = text//'  mpirun -n N beamwave-mpi '//usage(rows(i))// &
        '   the same, with the cases of sweeps shared among N processes'//nl
    end do
    text = text//nl//'  '//options_heading(rows)//nl
    do i = 1, size(options)
      text = text//column('    '//trim(options(i)%name)//' '//options(i)%value, 23)//trim(options(i)%help)//nl
    end do
    text = text//nl// &
      '  exit status: 0 done, 2 bad command line or scene, 3 a file failed or memory ran out, 4 some numbers'//nl// &
      '  cannot be trusted, 5 stopped with finished work saved, 70 a fault in the program'
  end function help_text

  pure function usage(row) result(text)
    !! Return a command and its words.
    type(command_row), intent(in) :: row
    character(:), allocatable :: text
    text = trim(trim(row%name)//' '//row%words%usage)
  end function usage

  pure function column(text, width) result(wide)
    !! Pad a text with blanks, at least one.
    character(*), intent(in) :: text
    integer, intent(in) :: width
    character(:), allocatable :: wide
    wide = trim(text)//repeat(' ', max(1, width - len_trim(text)))
  end function column

  pure function options_heading(rows) result(text)
    !! Say which commands take which of the options listed below; those that take most come first.
    type(command_row), intent(in) :: rows(:)
    character(:), allocatable :: text
    integer :: number, i, j
    text = ''
    do number = size(options), 1, -1
      do i = 1, size(rows)
        if (count(lists(rows(i)%options, options%name)) /= number .or. any(rows(:i - 1)%options == rows(i)%options)) cycle
        text = text//'; '//trim(rows(i)%name)
        do j = i + 1, size(rows)
          if (rows(j)%options == rows(i)%options) text = text//' and '//trim(rows(j)%name)
        end do
        if (number == size(options)) then
          text = text//' takes all of these'
        else
          text = text//trim(merge(' take ', ' takes', any(rows(i + 1:)%options == rows(i)%options)))//' '//trim(rows(i)%options)
        end if
      end do
    end do
    text = text(3:)
  end function options_heading

end module bw_command_table
