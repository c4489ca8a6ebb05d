program fuzz_scene_reader
  !! fuzz_scene_reader COUNT SCENE … [--write DIRECTORY]
  !!
  !! Damages scenes at random and lets the reader of scenes loose on them, COUNT texts in one process; ends with 1 at
  !! the first fault and shows the text. BEAMWAVE_SEED sets the seed. With --write each text is written as
  !! DIRECTORY/NNNNN.nml, and the resolved scene of one that is accepted as DIRECTORY/NNNNN.resolved.
  use, intrinsic :: iso_fortran_env, only: error_unit, output_unit
  use bw_kinds, only: dp
  use bw_text, only: string
  use fortran_reading, only: reading_type
  use random_streams, only: random_stream, stream_of_environment
  use scene_faults, only: judge
  use scene_mutations, only: damaged
  implicit none (type, external)

  real(dp), parameter :: most_seconds = 10.0_dp      !! for one text: beyond it, the reader hangs

  type(string), allocatable :: words(:), scenes(:)
  type(random_stream) :: random
  type(reading_type) :: reading
  character(:), allocatable :: directory
  integer :: texts, accepted
  real(dp) :: slowest

  call take_words(words, texts, directory)
  call read_scenes(words, scenes)
  random = stream_of_environment()
  write (output_unit, '(i0,a,i0,3a)') texts, ' texts made from ', size(scenes), ' scenes (', random%seed_text(), ')'
  call try_undamaged(scenes)
  call try_damaged(scenes)
  write (output_unit, '(i0,a,i0,a,i0,a,f0.3,a)') accepted, ' accepted; of their groups ', reading%compared, &
    ' compared with Fortran''s reading, ', reading%unread, ' not found by it; slowest text: ', slowest, ' s'
  if (10*reading%unread > reading%compared) call give_up('too few groups are compared for a judgement', '')

contains

  subroutine take_words(words, texts, directory)
    !! The command line: number of texts, scenes, where to write.
    type(string), allocatable, intent(out) :: words(:)
    integer, intent(out) :: texts
    character(:), allocatable, intent(out) :: directory     !! empty: nowhere
    type(string) :: all(command_argument_count())
    integer :: i, length, last, stat
    do i = 1, size(all)
      call get_command_argument(i, length=length)
      allocate (character(length) :: all(i)%text)
      call get_command_argument(i, all(i)%text)
    end do
    directory = ''
    last = size(all)
    stat = 1
    if (last >= 2) read (all(1)%text, *, iostat=stat) texts
    if (last >= 4) then
      if (all(last - 1)%text == '--write') directory = all(last)%text
    end if
    if (stat /= 0) call give_up('usage: fuzz_scene_reader COUNT SCENE ... [--write DIRECTORY]', '')
    if (directory /= '') last = last - 2
    words = all(2:last)
  end subroutine take_words

  subroutine read_scenes(paths, scenes)
    type(string), intent(in) :: paths(:)
    type(string), allocatable, intent(out) :: scenes(:)
    integer :: i, unit, bytes, stat
    allocate (scenes(size(paths)))
    do i = 1, size(paths)
      open (newunit=unit, file=paths(i)%text, access='stream', form='unformatted', action='read', status='old', &
            iostat=stat)
      if (stat /= 0) call give_up('cannot be read: '//paths(i)%text, '')
      inquire (unit, size=bytes)
      allocate (character(bytes) :: scenes(i)%text)
      read (unit) scenes(i)%text
      close (unit)
    end do
  end subroutine read_scenes

  subroutine try_undamaged(scenes)
    !! The scenes as they are: accepted, and every group compared.
    type(string), intent(in) :: scenes(:)
    character(:), allocatable :: fault, resolved
    integer :: i
    do i = 1, size(scenes)
      call judge(scenes(i)%text, fault, resolved, reading)
      if (fault == '' .and. resolved == '') fault = 'an undamaged scene is refused'
      if (fault == '' .and. reading%unread > 0) fault = 'Fortran cannot read an undamaged scene'
      if (fault /= '') call give_up(fault, scenes(i)%text)
    end do
  end subroutine try_undamaged

  subroutine try_damaged(scenes)
    type(string), intent(in) :: scenes(:)
    character(:), allocatable :: text, fault, resolved
    real(dp) :: before, after
    integer :: i, one, other
    text = ''
    accepted = 0
    slowest = 0.0_dp
    do i = 1, texts
      one = 1 + random%below(size(scenes))
      other = 1 + random%below(size(scenes))
      text = damaged(scenes(one)%text, scenes(other)%text, random)
      call cpu_time(before)
      call judge(text, fault, resolved, reading)
      call cpu_time(after)
      slowest = max(slowest, after - before)
      if (fault == '' .and. after - before > most_seconds) fault = 'too slow'
      if (fault /= '') call give_up(fault, text)
      if (resolved /= '') accepted = accepted + 1
      if (directory /= '') call write_texts(i, text, resolved)
    end do
  end subroutine try_damaged

  subroutine write_texts(i, text, resolved)
    integer, intent(in) :: i
    character(*), intent(in) :: text, resolved
    character(5) :: number
    write (number, '(i5.5)') i
    call write_file(directory//'/'//number//'.nml', text)
    if (resolved /= '') call write_file(directory//'/'//number//'.resolved', resolved)
  end subroutine write_texts

  subroutine write_file(path, text)
    character(*), intent(in) :: path, text
    integer :: unit
    open (newunit=unit, file=path, access='stream', form='unformatted', action='write', status='replace')
    write (unit) text
    close (unit)
  end subroutine write_file

  subroutine give_up(fault, text)
    character(*), intent(in) :: fault, text
    write (error_unit, '(a)') fault
    if (text /= '') write (error_unit, '(a)') '--- the text:', text, '---'
    stop 1, quiet=.true.
  end subroutine give_up

end program fuzz_scene_reader
