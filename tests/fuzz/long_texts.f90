program long_texts
  !! long_texts BYTES [TIMES]
  !!
  !! Lets the reader of scenes loose on long texts, each a short piece again and again: pieces that have been slow once or
  !! might be, and TIMES (10) times two tokens at random (BEAMWAVE_SEED sets the seed). Ends with 1 where a message is longer
  !! than a message is, or more errors are listed than anybody reads. Time and memory are in proportion to BYTES: CTest ends
  !! what takes more than its time, and by hand `valgrind --tool=callgrind` counts four times the instructions for four times
  !! the bytes.
  use, intrinsic :: iso_fortran_env, only: error_unit, output_unit
  use bw_error, only: error_type
  use bw_scene, only: scene_type
  use bw_scene_reader, only: read_scene_text
  use random_streams, only: random_stream, stream_of_environment
  implicit none (type, external)

  character, parameter :: nl = new_line('a')
  integer, parameter :: longest_line = 700, most_lines = 1001
  character(*), parameter :: beam = "&beam length=1, density=7870, youngs_modulus=2e11, diameter=0.037 /"
  character(*), parameter :: in_group = '&beam length=', in_sweep = "&sweep parameter='beam%length', values="
  character(24), parameter :: tokens(*) = [character(24) :: "'a'", '"', "''", ';', ',', '=', '/', '&', '&beam', '&sweep', &
    '&a /', '&end', '!', nl, '1', '0', '1e', 'x', 'x=', 'length=1', 'length = "', '2*', '9*', '2*1', '(', '%', &
    char(195)//char(188), char(255), achar(9), achar(13)//nl, '.', '.true.', '-', "='", 'beam%length', '$']

  integer :: bytes, times, read, i
  type(random_stream) :: random

  call take_words(bytes, times)
  read = 0
  do i = 1, size(tokens)
    call try(in_group, trim(tokens(i)), '')
    call try(in_sweep, trim(tokens(i))//' ', beam)
  end do
  call try(in_group//"'", 'a', "' /")
  call try(in_group//'0.', '0', '1e20000000 /')
  call try('&', 'beam', ' /')
  call try('', 'x', '')
  call try('', '&a /', beam)
  call try('', '&beam /'//nl, '')
  call try('! ', 'comment ', nl//beam)
  call try('', '&sweep parameter=''impact%mass'' values=1 /'//nl, beam)
  random = stream_of_environment()
  do i = 1, times
    call try(in_group, random_piece(), ' /')
  end do
  write (output_unit, '(i0,a,i0,3a)') read, ' texts of about ', bytes, ' bytes (', random%seed_text(), ')'

contains

  subroutine take_words(bytes, times)
    integer, intent(out) :: bytes, times
    character(20) :: word
    integer :: stat
    times = 10
    call get_command_argument(1, word)
    read (word, *, iostat=stat) bytes
    if (stat == 0 .and. command_argument_count() > 1) then
      call get_command_argument(2, word)
      read (word, *, iostat=stat) times
    end if
    if (stat /= 0) call give_up('usage: long_texts BYTES [TIMES]')
  end subroutine take_words

  function random_piece() result(piece)
    character(:), allocatable :: piece
    piece = trim(tokens(1 + random%below(size(tokens))))//repeat(' ', random%below(2))// &
            trim(tokens(1 + random%below(size(tokens))))
  end function random_piece

  subroutine try(before, piece, behind)
    !! A piece again and again, with something before and behind it.
    character(*), intent(in) :: before, piece, behind
    type(scene_type) :: scene
    type(error_type), allocatable :: error
    integer :: first, last, lines
    call read_scene_text(before//repeat(piece, bytes/max(1, len(piece)))//behind, 'x.nml', scene, error)
    read = read + 1
    if (.not. allocated(error)) return
    lines = 0
    first = 1
    do while (first <= len(error%message))
      last = index(error%message(first:), nl) + first - 1
      if (last < first) last = len(error%message)
      lines = lines + 1
      if (last - first > longest_line) call give_up('a message of '''//piece//''' is too long: '//error%message(first:last))
      first = last + 1
    end do
    if (lines > most_lines) call give_up('too many errors are listed of '''//piece//'''')
  end subroutine try

  subroutine give_up(fault)
    character(*), intent(in) :: fault
    write (error_unit, '(a)') fault
    stop 1, quiet=.true.
  end subroutine give_up

end program long_texts
